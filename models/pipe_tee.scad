// Reducing pipe tee with three bolted flanges and O-ring grooves. Millimetres. The run lies along
// x, the branch stands along z.

run_d     = 60;     // outer diameter of the run
branch_d  = 42;
pipe_t    = 4;      // of either pipe
run_l     = 140;
branch_l  = 75;     // from the axis of the run to the branch's face
flange_t  = 10;
flange_over = 26;   // flange radius beyond the pipe's
bolts     = 4;
bolt_d    = 9;
ring      = 1.6;    // radius of the O-ring's cord
bead      = 2;      // weld bead round the foot of each flange

over = 1;

// A flange about z with its sealing face at z = 0, the pipe leaving downward.
module flange(pipe_d) {
    r = pipe_d / 2;
    translate([0, 0, -flange_t]) cylinder(h = flange_t, r = r + flange_over);
    translate([0, 0, -flange_t]) torus(r, bead);
}

module flange_cuts(pipe_d) {
    r = pipe_d / 2;
    torus(r + 5, ring);
    for (i = [0 : bolts - 1]) rotate([0, 0, (i + 0.5) * 360 / bolts])
        translate([r + 16, 0, -flange_t - over]) cylinder(h = flange_t + 2 * over, d = bolt_d);
}

// Puts children at the three openings; $pipe_d tells which pipe it is.
module at_ends() {
    for (side = [0, 1]) let ($pipe_d = run_d)
        mirror([side, 0, 0]) translate([run_l / 2, 0, 0]) rotate([0, 90, 0]) children();
    let ($pipe_d = branch_d) translate([0, 0, branch_l]) children();
}

difference() {
    union() {
        rotate([0, 90, 0]) cylinder(h = run_l, d = run_d, center = true);
        cylinder(h = branch_l, d = branch_d);
        at_ends() flange($pipe_d);
    }
    rotate([0, 90, 0]) cylinder(h = run_l + 2 * over, d = run_d - 2 * pipe_t, center = true);
    cylinder(h = branch_l + over, d = branch_d - 2 * pipe_t);
    at_ends() flange_cuts($pipe_d);
}
