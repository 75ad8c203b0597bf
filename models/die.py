"""Die with rounded corners and scooped pips: the part of die.scad, built from Python."""

import genus

SIDE = 16  # millimetres
ROUND_D = 24  # ball that takes the corners off
PIP_R, PIP_OUT = 1.6, 0.6  # scoop, and its centre above the face
SPREAD = 4  # from the middle of a face to its outer pips

# Turns the top face to where face n goes; opposite faces add up to seven.
TURNS = [(0, 0, 0), (90, 0, 0), (0, 90, 0), (0, -90, 0), (-90, 0, 0), (180, 0, 0)]


def pips(n: int) -> list[tuple[int, int]]:
    """Where the pips of face n are, in units of SPREAD."""
    places = [(0, 0)] if n % 2 else []
    places += [(-1, -1), (1, 1)] if n >= 2 else []
    places += [(-1, 1), (1, -1)] if n >= 4 else []
    places += [(-1, 0), (1, 0)] if n == 6 else []
    return places


def part() -> genus.Solid:
    body = genus.cube(SIDE, center=True) & genus.sphere(d=ROUND_D)
    scoop = genus.sphere(PIP_R)
    cuts = [
        scoop.translate([x * SPREAD, y * SPREAD, SIDE / 2 + PIP_OUT]).rotate(turn)
        for n, turn in enumerate(TURNS, start=1)
        for x, y in pips(n)
    ]
    return genus.difference(body, *cuts)


if __name__ == "__main__":
    mesh = part().mesh(tolerance=0.05)
    mesh.save("die.stl")
    print(mesh.report())
