"""Reducing pipe tee: the part of pipe_tee.scad, built from Python. Millimetres."""

from collections.abc import Callable

import genus

RUN_D, BRANCH_D, PIPE_T = 60, 42, 4  # outer diameters, wall of either pipe
RUN_L, BRANCH_L = 140, 75  # the branch from the axis of the run to its face
FLANGE_T, FLANGE_OVER = 10, 26  # flange radius beyond the pipe's
BOLTS, BOLT_D = 4, 9
RING = 1.6  # radius of the O-ring's cord
BEAD = 2  # weld bead round the foot of each flange
OVER = 1


def flange(pipe_d: float) -> genus.Solid:
    """About z with its sealing face at z = 0, the pipe leaving downward."""
    disc = genus.cylinder(h=FLANGE_T, r=pipe_d / 2 + FLANGE_OVER)
    return (disc + genus.torus(pipe_d / 2, BEAD)).translate([0, 0, -FLANGE_T])


def flange_cuts(pipe_d: float) -> genus.Solid:
    bolt = genus.cylinder(h=FLANGE_T + 2 * OVER, d=BOLT_D)
    bolt = bolt.translate([pipe_d / 2 + 16, 0, -FLANGE_T - OVER])
    bolts = [bolt.rotate((i + 0.5) * 360 / BOLTS) for i in range(BOLTS)]
    return genus.union(genus.torus(pipe_d / 2 + 5, RING), *bolts)


def at_ends(make: Callable[[float], genus.Solid]) -> genus.Solid:
    """What `make` gives for each pipe's diameter, put at the three openings."""
    right = make(RUN_D).rotate([0, 90, 0]).translate([RUN_L / 2, 0, 0])
    return right + right.mirror([1, 0, 0]) + make(BRANCH_D).translate([0, 0, BRANCH_L])


def part() -> genus.Solid:
    run = genus.cylinder(h=RUN_L, d=RUN_D, center=True)
    bore = genus.cylinder(h=RUN_L + 2 * OVER, d=RUN_D - 2 * PIPE_T, center=True)
    branch = genus.cylinder(h=BRANCH_L, d=BRANCH_D)
    branch_bore = genus.cylinder(h=BRANCH_L + OVER, d=BRANCH_D - 2 * PIPE_T)
    body = run.rotate([0, 90, 0]) + branch + at_ends(flange)
    return genus.difference(body, bore.rotate([0, 90, 0]), branch_bore, at_ends(flange_cuts))


if __name__ == "__main__":
    mesh = part().mesh(tolerance=0.05)
    mesh.save("pipe_tee.stl")
    print(mesh.report())
