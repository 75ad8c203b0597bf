"""Control knob for a 6 mm D-shaft: the part of knob.scad, built from Python. Millimetres."""

import genus

KNOB_D, KNOB_H, DOME_R = 32, 18, 40
SCALLOPS, SCALLOP_D = 12, 7
SKIRT_D, SKIRT_H = 38, 4
SHAFT_D, SHAFT_FLAT, SHAFT_L = 6, 1.5, 12  # the flat takes that much of the shaft away
SCREW_D = 2.5  # set screw, against the flat
OVER = 1


def shaft() -> genus.Solid:
    rod = genus.cylinder(h=SHAFT_L + OVER, d=SHAFT_D).translate([0, 0, -OVER])
    return rod & genus.half_space([1, 0, 0], SHAFT_D / 2 - SHAFT_FLAT)


def part() -> genus.Solid:
    dome = genus.sphere(DOME_R).translate([0, 0, KNOB_H - 1 - DOME_R])
    body = genus.cylinder(h=KNOB_H, d1=KNOB_D + 1, d2=KNOB_D - 2) & dome
    body += genus.cylinder(h=SKIRT_H, d=SKIRT_D)
    scallop = genus.cylinder(h=KNOB_H, d=SCALLOP_D).translate([KNOB_D / 2 + 2, 0, SKIRT_H + 1])
    cuts = [scallop.rotate((i + 0.5) * 360 / SCALLOPS) for i in range(SCALLOPS)]
    cuts.append(genus.torus(SKIRT_D / 2, 0.8).translate([0, 0, SKIRT_H / 2]))
    screw = genus.cylinder(h=KNOB_D, d=SCREW_D).rotate([0, 90, 0]).translate([0, 0, 7])
    pointer = genus.cylinder(h=KNOB_D, r=1).rotate([0, 90, 0]).translate([6, 0, KNOB_H - 0.6])
    return genus.difference(body, *cuts, shaft(), screw, pointer)


if __name__ == "__main__":
    mesh = part().mesh(tolerance=0.05)
    mesh.save("knob.stl")
    print(mesh.report())
