"""Perforated shelf bracket: the part of bracket.scad, built from Python. Millimetres."""

import genus

WIDTH, ARM, WALL, PLATE = 60, 90, 70, 4  # the arm carries the shelf, the wall plate is screwed on
HOLE_D, PITCH, COLUMNS, ROWS = 6, 10, 6, 5
SCREW_D, SLOT = 5, 8  # travel of the screw in its slot
RIB_T, RIB = 4, (58, 44)
OVER = 1


def slot_cut() -> genus.Solid:
    """A slot through the wall plate, its length along z."""
    end = genus.cylinder(h=PLATE + 2 * OVER, d=SCREW_D)
    middle = genus.cube([SLOT, SCREW_D, PLATE + 2 * OVER]).translate([-SLOT / 2, -SCREW_D / 2, 0])
    slot = middle + end.translate([-SLOT / 2, 0, 0]) + end.translate([SLOT / 2, 0, 0])
    return slot.rotate([0, 90, 0]).translate([-OVER, 0, 0])


def rib(length: float, height: float, thickness: float) -> genus.Solid:
    """Triangle in the xz plane with its right angle at the origin."""
    plate = genus.cube([length, thickness, height])
    return plate & genus.half_space([height, 0, length], height * length)


def part() -> genus.Solid:
    solid = genus.cube([ARM, WIDTH, PLATE]) + genus.cube([PLATE, WIDTH, WALL])
    for y in (0, WIDTH - RIB_T):
        solid += rib(*RIB, RIB_T).translate([PLATE - 1, y, PLATE - 1])
    cuts = []
    hole = genus.cylinder(h=PLATE + 2 * OVER, d=HOLE_D).translate([0, 0, -OVER])
    for r in range(ROWS):
        y = WIDTH / 2 + (r - (ROWS - 1) / 2) * PITCH
        cuts += [hole.translate([20 + (c + r % 2 / 2) * PITCH, y, 0]) for c in range(COLUMNS)]
    cuts += [slot_cut().translate([0, y, WALL - 15]) for y in (15, WIDTH - 15)]
    screw = genus.cylinder(h=PLATE + 2 * OVER, d=SCREW_D).rotate([0, 90, 0])
    cuts.append(screw.translate([-OVER, WIDTH / 2, WALL / 2]))
    return genus.difference(solid, *cuts)


if __name__ == "__main__":
    mesh = part().mesh(tolerance=0.05)
    mesh.save("bracket.stl")
    print(mesh.report())
