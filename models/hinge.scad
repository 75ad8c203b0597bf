// Butt hinge, two leaves on a loose pin, opened by `angle`. Millimetres. Three bodies with
// clearance between them, as it would be printed in place.

leaf_w    = 32;     // from the pin's axis to the free edge
leaf_h    = 60;
leaf_t    = 3;
knuckles  = 5;
knuckle_d = 9;
pin_d     = 4;
clearance = 0.3;    // on every moving fit
screw_d   = 4.2;
screw_head_d = 8.4; // countersunk
angle     = 120;    // between the leaves

over = 1;
pitch = leaf_h / knuckles;

// The leaf lies in the xz plane beside the pin, knuckles number `first`, `first` + 2, ... are its
// own, the others are cut out with clearance.
module leaf(first) {
    difference() {
        union() {
            translate([0, -leaf_t / 2, 0]) cube([leaf_w, leaf_t, leaf_h]);
            for (i = [first : 2 : knuckles - 1])
                translate([0, 0, i * pitch + clearance / 2])
                    cylinder(h = pitch - clearance, d = knuckle_d);
        }
        for (i = [1 - first : 2 : knuckles - 1])
            translate([0, 0, i * pitch - clearance / 2])
                cylinder(h = pitch + clearance, d = knuckle_d + 4 * clearance);
        translate([0, 0, -over]) cylinder(h = leaf_h + 2 * over, d = pin_d + 2 * clearance);
        for (row = [0 : 2]) {
            x = row == 1 ? leaf_w * 0.75 : leaf_w * 0.5;
            translate([x, 0, (row + 0.5) * leaf_h / 3]) rotate([90, 0, 0]) {
                cylinder(h = leaf_t + 2 * over, d = screw_d, center = true);
                // Countersink on the side y > 0, a cone of 90 degrees.
                translate([0, 0, -leaf_t / 2 - over]) cylinder(
                    h = screw_head_d / 2 + over, r1 = screw_head_d / 2 + over, r2 = 0);
            }
        }
    }
}

module pin() {
    translate([0, 0, -2]) cylinder(h = leaf_h + 4, d = pin_d);
    // Heads that keep it in place: a button below, a ball above.
    translate([0, 0, -3]) cylinder(h = 2.5, d = knuckle_d - 1);
    translate([0, 0, leaf_h + 3]) sphere(d = pin_d + 2);
}

leaf(0);
rotate([0, 0, angle]) leaf(1);
pin();
