"""Butt hinge: the part of hinge.scad, built from Python. Millimetres."""

import genus

LEAF_W, LEAF_H, LEAF_T = 32, 60, 3  # width from the pin's axis to the free edge
KNUCKLES, KNUCKLE_D = 5, 9
PIN_D = 4
CLEARANCE = 0.3  # on every moving fit
SCREW_D, SCREW_HEAD_D = 4.2, 8.4  # countersunk
ANGLE = 120  # between the leaves
OVER = 1
PITCH = LEAF_H / KNUCKLES


def screw_hole() -> genus.Solid:
    """Hole and cone of 90 degrees, along y, the head on the side y > 0."""
    hole = genus.cylinder(h=LEAF_T + 2 * OVER, d=SCREW_D, center=True)
    head = genus.cone(h=SCREW_HEAD_D / 2 + OVER, r=SCREW_HEAD_D / 2 + OVER)
    return (hole + head.translate([0, 0, -LEAF_T / 2 - OVER])).rotate([90, 0, 0])


def leaf(first: int) -> genus.Solid:
    """Knuckles `first`, `first` + 2, ... are its own, the others are cut out with clearance."""
    solid = genus.cube([LEAF_W, LEAF_T, LEAF_H]).translate([0, -LEAF_T / 2, 0])
    for i in range(first, KNUCKLES, 2):
        knuckle = genus.cylinder(h=PITCH - CLEARANCE, d=KNUCKLE_D)
        solid += knuckle.translate([0, 0, i * PITCH + CLEARANCE / 2])
    cuts = [genus.cylinder(h=LEAF_H + 2 * OVER, d=PIN_D + 2 * CLEARANCE).translate([0, 0, -OVER])]
    for i in range(1 - first, KNUCKLES, 2):
        room = genus.cylinder(h=PITCH + CLEARANCE, d=KNUCKLE_D + 4 * CLEARANCE)
        cuts.append(room.translate([0, 0, i * PITCH - CLEARANCE / 2]))
    for row in range(3):
        x = LEAF_W * (0.75 if row == 1 else 0.5)
        cuts.append(screw_hole().translate([x, 0, (row + 0.5) * LEAF_H / 3]))
    return genus.difference(solid, *cuts)


def pin() -> genus.Solid:
    rod = genus.cylinder(h=LEAF_H + 4, d=PIN_D).translate([0, 0, -2])
    button = genus.cylinder(h=2.5, d=KNUCKLE_D - 1).translate([0, 0, -3])
    ball = genus.sphere(d=PIN_D + 2).translate([0, 0, LEAF_H + 3])
    return rod + button + ball


def part() -> genus.Solid:
    return leaf(0) + leaf(1).rotate(ANGLE) + pin()


if __name__ == "__main__":
    mesh = part().mesh(tolerance=0.05)
    mesh.save("hinge.stl")
    print(mesh.report())
