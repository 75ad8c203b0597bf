// Flanged bearing block: a foot to bolt down, a housing for a 40 mm bearing with a snap-ring
// groove, a flange to close it, gussets, and a grease hole. Millimetres.

bearing_d    = 40;    // outer ring of the bearing
bearing_w    = 26;    // depth of its seat
shaft_d      = 30;    // clear hole behind the seat
axis_h       = 54;    // shaft axis above the foot's underside
housing_d    = 62;
housing_w    = 44;
foot         = [124, 52, 14];
foot_hole_d  = 9;     // M8, with a flat for its head
foot_holes   = [48, 15];
flange_d     = 86;
flange_t     = 8;
flange_bolts = 6;
flange_bolt_d = 6.6;  // M6
groove       = 1.2;   // radius of the snap ring's wire
grease_d     = 5;

over = 1;             // cutters reach this far beyond what they cut

// What is built along z, turned to lie along y with its middle at the shaft axis.
module on_axis() translate([0, 0, axis_h]) rotate([90, 0, 0]) children();

// A right triangle of plate: `l` along x, `h` along z, `t` thick about y = 0.
module gusset(l, h, t) {
    difference() {
        translate([0, -t / 2, 0]) cube([l, t, h]);
        translate([l, 0, 0]) rotate([0, -atan2(l, h), 0])
            translate([0, -t, -over]) cube([2 * l, 2 * t, 2 * (l + h)]);
    }
}

module foot() {
    difference() {
        translate([-foot[0] / 2, -foot[1] / 2, 0]) cube(foot);
        for (x = [-1, 1], y = [-1, 1]) {
            translate([x * foot_holes[0], y * foot_holes[1], -over])
                cylinder(h = foot[2] + 2 * over, d = foot_hole_d);
            translate([x * foot_holes[0], y * foot_holes[1], foot[2] - 3])
                cylinder(h = 3 + over, d = 2 * foot_hole_d);
            // Corners cut at 45 degrees.
            translate([x * foot[0] / 2, y * foot[1] / 2, foot[2] / 2]) rotate([0, 0, 45])
                cube([12, 12, foot[2] + 2 * over], center = true);
        }
    }
}

module body() {
    foot();
    // Web under the housing, a little narrower than it.
    translate([-27, -17, foot[2] / 2]) cube([54, 34, axis_h - foot[2] / 2]);
    on_axis() cylinder(h = housing_w, d = housing_d, center = true);
    // Flange on the far side.
    on_axis() translate([0, 0, -housing_w / 2]) cylinder(h = flange_t, d = flange_d);
    for (side = [0, 1]) mirror([side, 0, 0])
        translate([26, 0, foot[2] - 1]) gusset(22, 26, 8);
    // Boss for the grease nipple.
    translate([0, 0, axis_h]) cylinder(h = housing_d / 2 + 4, d = 14);
}

module cuts() {
    on_axis() {
        cylinder(h = housing_w + 2 * flange_t + 2 * over, d = shaft_d, center = true);
        translate([0, 0, housing_w / 2 - bearing_w]) cylinder(h = bearing_w + over, d = bearing_d);
        translate([0, 0, housing_w / 2 - 4]) torus(bearing_d / 2, groove);
        for (i = [0 : flange_bolts - 1])
            rotate([0, 0, i * 360 / flange_bolts]) translate([37, 0, -housing_w / 2 - over])
                cylinder(h = flange_t + 2 * over, d = flange_bolt_d);
    }
    translate([0, 0, axis_h]) cylinder(h = housing_d / 2 + 4 + over, d = grease_d);
}

difference() {
    body();
    cuts();
}
