// The teapot as a solid of patches, with a bite taken out of its side, and a bail bent from a
// straight bar by a lattice.
//
//     genus build models/teapot.scad -o teapot.stl --tolerance 0.001

bite = 0.8;      // radius of the ball
bail_r = 0.12;   // radius of the bar
span = 2.9;      // its length before it is bent
rise = 4;        // of the lattice's middle; the bail rises to about three quarters of it

module bail() {
    // Degree 4 along the bar: both end sections rest, the three inner ones go up, and the two
    // outer of these a little outward.
    ffd(degree = [4, 1, 1],
        moves = [for (i = [1:3], j = [0:1], k = [0:1])
            [[i, j, k], [0.4 * (i - 2), 0, i == 2 ? rise : 0.6 * rise]]])
        translate([-span / 2, 0, 2.2])
            rotate([0, 90, 0])
                cylinder(h = span, r = bail_r);
}

difference() {
    patches("patches/teapot.bpt");
    translate([0, -1.9, 1.2]) sphere(bite);
}
bail();
