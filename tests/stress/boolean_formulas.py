"""Random booleans in genus and manifold3d, and the exact answer wherever they differ.

    python tests/stress/boolean_formulas.py [--rounds 10000] [--first 0]

Solids in bad positions: whole coordinates, common planes, turned by 10^-k degrees. Where the two
volumes differ by more than rounding explains, points are tried one by one: whether a point is
inside follows from the winding numbers of the operands, which no library is asked for. A line says
the seed and how many of the points each result has on the wrong side. Exit status 1 if genus is
wrong anywhere.
"""

from __future__ import annotations

import sys

import genus
import manifold3d
import numpy as np
from rounds import run_rounds

Arrays = tuple[np.ndarray, np.ndarray]
POINTS = 4000
OPERATIONS = "+-&"


def box(size: np.ndarray) -> Arrays:
    """A box from the origin."""
    is_high = np.arange(8)[:, None] >> np.arange(3) & 1
    faces = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4]]
    faces += [[2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]
    return is_high * size, np.array(faces)


def random_solid(dice: np.random.Generator) -> Arrays:
    """A box, a tetrahedron or a ball of few faces, put where it meets others badly."""
    kind = dice.integers(3)
    if kind == 0:
        vertices, faces = box(dice.integers(1, 4, 3).astype(float))
    elif kind == 1:
        while True:
            vertices = dice.integers(-2, 3, (4, 3)).astype(float)
            volume = np.linalg.det(vertices[1:] - vertices[0])
            if volume != 0:
                break
        faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
        faces = faces if volume > 0 else faces[:, ::-1]
    else:
        ball = genus.icosphere(1.5, 2)
        vertices, faces = np.array(ball.vertices), np.array(ball.faces)
    place = dice.integers(4)
    if place == 0:
        angle = np.radians(10.0 ** -dice.integers(1, 17))
    else:
        angle = dice.random() * 2 * np.pi if place == 1 else 0.0
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    vertices = vertices @ turn.T + dice.integers(-2, 3, 3) / 2
    return vertices, faces


def winding(points: np.ndarray, arrays: Arrays) -> np.ndarray:
    """How often a closed mesh winds round each point, by solid angles."""
    vertices, faces = arrays
    a, b, c = (vertices[faces[:, i]][None] - points[:, None] for i in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    triple = np.einsum("pfi,pfi->pf", a, np.cross(b, c))
    dots = [np.einsum("pfi,pfi->pf", u, v) for u, v in ((a, b), (b, c), (c, a))]
    below = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    return np.rint(np.arctan2(triple, below).sum(axis=1) / (2 * np.pi)).astype(int)


def by_genus(solids: list[Arrays], operations: str) -> Arrays:
    """From left to right."""
    meshes = [genus.Mesh(*solid) for solid in solids]
    formula: object = 0
    for i, operation in enumerate(operations):
        formula = (operation, formula, i + 1)
    mesh = genus.boolean(formula, meshes)
    topology = mesh.topology
    if len(mesh) and not (topology.closed and topology.manifold):
        raise AssertionError("not closed and manifold")
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def by_manifold(solids: list[Arrays], operations: str) -> Arrays:
    """The same."""
    parts = [
        manifold3d.Manifold(
            manifold3d.Mesh64(
                vert_properties=np.ascontiguousarray(vertices),
                tri_verts=np.ascontiguousarray(faces, np.uint64),
            )
        )
        for vertices, faces in solids
    ]
    result = parts[0]
    for operation, part in zip(operations, parts[1:], strict=True):
        result = {"+": result + part, "-": result - part, "&": result ^ part}[operation]
    mesh = result.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(int)


def inside(points: np.ndarray, solids: list[Arrays], operations: str) -> np.ndarray:
    """The exact answer, point by point."""
    result = winding(points, solids[0]) != 0
    for operation, solid in zip(operations, solids[1:], strict=True):
        other = winding(points, solid) != 0
        result = {"+": result | other, "-": result & ~other, "&": result & other}[operation]
    return result


def volume(arrays: Arrays) -> float:
    """Signed."""
    vertices, faces = arrays
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6) if len(faces) else 0.0


def try_seed(seed: int) -> str:
    """The kind of outcome; a difference is explained on standard output."""
    dice = np.random.default_rng(seed)
    solids = [random_solid(dice) for _ in range(dice.integers(2, 5))]
    operations = "".join(OPERATIONS[i] for i in dice.integers(0, 3, len(solids) - 1))
    try:
        ours = by_genus(solids, operations)
    except genus.Error as error:
        print(f"seed {seed} {operations} refused: {error}")
        return "refused"
    theirs = by_manifold(solids, operations)
    if abs(volume(ours) - volume(theirs)) <= 1e-9:
        return "agree"
    corners = np.concatenate([vertices for vertices, _ in solids])
    points = dice.uniform(corners.min(axis=0) - 0.1, corners.max(axis=0) + 0.1, (POINTS, 3))
    truth = inside(points, solids, operations)
    wrong = [
        int(((winding(points, result) > 0) != truth).sum()) if len(result[1]) else int(truth.sum())
        for result in (ours, theirs)
    ]
    print(
        f"seed {seed} {operations}: volume {volume(ours):.12g} and {volume(theirs):.12g};"
        f" of {POINTS} points genus has {wrong[0]} wrong, manifold3d {wrong[1]}"
    )
    if wrong[0]:
        return "genus wrong"
    return "manifold3d wrong" if wrong[1] else "differ by less than the points show"


if __name__ == "__main__":
    sys.exit(run_rounds(try_seed, __doc__, 10_000, "genus wrong"))
