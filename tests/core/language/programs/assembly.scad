include <settings.scad>
use <parts.scad>
width = 24;                // overrides what settings.scad says, which height follows
clearance = 5;             // not that of parts.scad
$fa = 6;
$fs = 0.5;
module stack(spacing = 1) {
    for (i = [0:1:$children-1]) translate([0, 0, i * spacing]) children(i);
}
module tree(level, length = 10) {
    if (level > 0) {
        cylinder(h = length, r1 = length / 6, r2 = length / 8);
        translate([0, 0, length]) for (a = [-30, 30]) rotate([0, a, 0]) tree(level - 1, length * 0.7);
    } else
        sphere(length / 5);
}
module show_fn() echo(fn = $fn, fa = $fa);
echo(width, height, bore(3), clearance);
label("whole");
plate([width, height, 3], [[4, 6, 3], [20, 6, 4]]);
shell() { cube(8); cube([8, 8, 8] - [1.2, 1.2, 0]); }
ring(4, 30) color([$ring_index / 3, 0, 0]) rotate([0, 0, $ring_index]) cube($ring_index + 1);
translate([50, 0, 0]) stack(4) { cube(2); sphere(r = 1, $fn = 8); union() { module_free = 3; cylinder(r = module_free); } }
tree(2);
module outer() { module inner() { show_fn($fn = 7); children(); } inner() children(); }
outer() { echo(inside = $parent_modules); show_fn(); }
intersection() { mirror([1, 1, 0]) cube([3, 2, 1]); *sphere(10); #cube(2); %cube(3); }
intersection_for (a = [0:60:120]) rotate(a) cube([10, 4, 4], center = true);
resize([2, 0, 0]) cube(1);
render() if (height > 10) scale([1, 2, 3]) sphere(2); else cube();
multmatrix([[1, 0, 0.5, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) cube(1);
linear_extrude(height = 3, twist = 90, slices = 4) offset(delta = 1) polygon([[0, 0], [2, 0], [1, 2]]);
let (a = 2, b = a + 1) { c = a * b; translate([c, 0]) cube([a, b, c]); }
