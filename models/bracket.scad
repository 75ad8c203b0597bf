// Perforated shelf bracket: an angle of 4 mm plate with a field of holes in one arm, screw slots
// in the other, and two ribs. Millimetres.

width     = 60;
arm       = 90;     // along x, carries the shelf
wall      = 70;     // along z, screwed to the wall
plate     = 4;
hole_d    = 6;
pitch     = 10;
columns   = 6;
rows      = 5;
screw_d   = 5;
slot      = 8;      // travel of the screw in its slot
rib_t     = 4;
rib       = [58, 44];

over = 1;

module slot_cut() {
    translate([-over, 0, 0]) rotate([0, 90, 0]) {
        for (x = [-1, 1]) translate([x * slot / 2, 0, 0]) cylinder(h = plate + 2 * over, d = screw_d);
        translate([-slot / 2, -screw_d / 2, 0]) cube([slot, screw_d, plate + 2 * over]);
    }
}

// Triangle in the xz plane with its right angle at the origin and legs l and h.
module rib(l, h, t) {
    difference() {
        cube([l, t, h]);
        translate([l, 0, 0]) rotate([0, -atan2(l, h), 0])
            translate([0, -over, -over]) cube([2 * l, t + 2 * over, 2 * (l + h)]);
    }
}

difference() {
    union() {
        cube([arm, width, plate]);
        cube([plate, width, wall]);
        for (y = [0, width - rib_t])
            translate([plate - 1, y, plate - 1]) rib(rib[0], rib[1], rib_t);
    }
    // Holes over the arm, every second row shifted by half a pitch.
    for (r = [0 : rows - 1], c = [0 : columns - 1])
        translate([20 + c * pitch + (r % 2) * pitch / 2, width / 2 + (r - (rows - 1) / 2) * pitch,
                   -over])
            cylinder(h = plate + 2 * over, d = hole_d);
    for (y = [15, width - 15]) translate([0, y, wall - 15]) slot_cut();
    translate([-over, width / 2, wall / 2]) rotate([0, 90, 0])
        cylinder(h = plate + 2 * over, d = screw_d);
}
