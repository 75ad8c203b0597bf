// Used by assembly.scad: its variables stay its own.
clearance = 0.2;
wall = 3 * clearance;
function bore(d) = d + 2 * clearance;
module plate(size, holes = [], $fn = 24) {
    difference() {
        cube(size);
        for (h = holes) translate([h.x, h.y, -1]) cylinder(d = bore(h[2]), h = size.z + 2);
    }
}
module shell(t = wall) {
    difference() {
        children(0);
        translate([t, t, t]) children(1);
    }
}
module ring(n, r) {
    for (i = [0:n-1]) rotate(360 / n * i) translate([r, 0, 0]) { $ring_index = i; children(); }
}
