// Control knob for a 6 mm D-shaft: domed top, finger scallops, grip groove, set screw, pointer.
// Millimetres.

knob_d    = 32;
knob_h    = 18;
dome_r    = 40;     // radius of the domed top
scallops  = 12;
scallop_d = 7;
skirt_d   = 38;
skirt_h   = 4;
shaft_d   = 6;
shaft_flat = 1.5;   // how much of the shaft the flat takes away
shaft_l   = 12;
screw_d   = 2.5;    // set screw, against the flat

over = 1;

module shaft() {
    difference() {
        translate([0, 0, -over]) cylinder(h = shaft_l + over, d = shaft_d);
        translate([shaft_d / 2 - shaft_flat, -shaft_d, -2 * over])
            cube([shaft_d, 2 * shaft_d, shaft_l + 3 * over]);
    }
}

difference() {
    union() {
        intersection() {
            cylinder(h = knob_h, d1 = knob_d + 1, d2 = knob_d - 2);
            translate([0, 0, knob_h - 1 - dome_r]) sphere(r = dome_r);
        }
        cylinder(h = skirt_h, d = skirt_d);
    }
    for (i = [0 : scallops - 1]) rotate([0, 0, (i + 0.5) * 360 / scallops])
        translate([knob_d / 2 + 2, 0, skirt_h + 1]) cylinder(h = knob_h, d = scallop_d);
    // Ring groove in the skirt.
    translate([0, 0, skirt_h / 2]) torus(skirt_d / 2, 0.8);
    shaft();
    translate([0, 0, 7]) rotate([0, 90, 0]) cylinder(h = knob_d, d = screw_d);
    // Pointer: a round-bottomed line on the dome.
    translate([6, 0, knob_h - 0.6]) rotate([0, 90, 0]) cylinder(h = knob_d, r = 1);
}
