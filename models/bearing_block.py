"""Flanged bearing block: the part of bearing_block.scad, built from Python. Millimetres."""

import genus

BEARING_D, BEARING_W = 40, 26  # outer ring of the bearing, depth of its seat
SHAFT_D = 30  # clear hole behind the seat
AXIS_H = 54  # shaft axis above the foot's underside
HOUSING_D, HOUSING_W = 62, 44
FOOT = (124, 52, 14)
FOOT_HOLE_D, FOOT_HOLES = 9, (48, 15)  # M8, with a flat for its head
FLANGE_D, FLANGE_T, FLANGE_BOLTS, FLANGE_BOLT_D = 86, 8, 6, 6.6
GROOVE = 1.2  # radius of the snap ring's wire
GREASE_D = 5
OVER = 1  # cutters reach this far beyond what they cut


def on_axis(solid: genus.Solid) -> genus.Solid:
    """What is built along z, turned to lie along y with its middle at the shaft axis."""
    return solid.rotate([90, 0, 0]).translate([0, 0, AXIS_H])


def gusset(length: float, height: float, thickness: float) -> genus.Solid:
    """A right triangle of plate in the xz plane, cut from a box by one half-space."""
    plate = genus.cube([length, thickness, height]).translate([0, -thickness / 2, 0])
    return plate & genus.half_space([height, 0, length], height * length)


def foot() -> genus.Solid:
    solid = genus.cube(FOOT).translate([-FOOT[0] / 2, -FOOT[1] / 2, 0])
    cuts = []
    for x in (-1, 1):
        for y in (-1, 1):
            hole = genus.cylinder(h=FOOT[2] + 2 * OVER, d=FOOT_HOLE_D).translate([0, 0, -OVER])
            flat = genus.cylinder(h=3 + OVER, d=2 * FOOT_HOLE_D).translate([0, 0, FOOT[2] - 3])
            cuts.append((hole + flat).translate([x * FOOT_HOLES[0], y * FOOT_HOLES[1], 0]))
            corner = genus.cube([12, 12, FOOT[2] + 2 * OVER], center=True).rotate(45)
            cuts.append(corner.translate([x * FOOT[0] / 2, y * FOOT[1] / 2, FOOT[2] / 2]))
    return genus.difference(solid, *cuts)


def body() -> genus.Solid:
    web = genus.cube([54, 34, AXIS_H - FOOT[2] / 2]).translate([-27, -17, FOOT[2] / 2])
    housing = on_axis(genus.cylinder(h=HOUSING_W, d=HOUSING_D, center=True))
    flange = genus.cylinder(h=FLANGE_T, d=FLANGE_D).translate([0, 0, -HOUSING_W / 2])
    right = gusset(22, 26, 8).translate([26, 0, FOOT[2] - 1])
    boss = genus.cylinder(h=HOUSING_D / 2 + 4, d=14).translate([0, 0, AXIS_H])
    return genus.union(foot(), web, housing, on_axis(flange), right, right.mirror([1, 0, 0]), boss)


def cuts() -> genus.Solid:
    clear = genus.cylinder(h=HOUSING_W + 2 * FLANGE_T + 2 * OVER, d=SHAFT_D, center=True)
    seat = genus.cylinder(h=BEARING_W + OVER, d=BEARING_D)
    seat = seat.translate([0, 0, HOUSING_W / 2 - BEARING_W])
    groove = genus.torus(BEARING_D / 2, GROOVE).translate([0, 0, HOUSING_W / 2 - 4])
    bolt = genus.cylinder(h=FLANGE_T + 2 * OVER, d=FLANGE_BOLT_D)
    bolt = bolt.translate([37, 0, -HOUSING_W / 2 - OVER])
    bolts = [bolt.rotate(i * 360 / FLANGE_BOLTS) for i in range(FLANGE_BOLTS)]
    grease = genus.cylinder(h=HOUSING_D / 2 + 4 + OVER, d=GREASE_D).translate([0, 0, AXIS_H])
    return on_axis(genus.union(clear, seat, groove, *bolts)) + grease


def part() -> genus.Solid:
    return body() - cuts()


if __name__ == "__main__":
    mesh = part().mesh(tolerance=0.05)
    mesh.save("bearing_block.stl")
    print(mesh.report())
