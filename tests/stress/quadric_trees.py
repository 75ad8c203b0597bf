"""Random quadric trees in genus and, finely tessellated, in manifold3d: is the form the same?

    python tests/stress/quadric_trees.py [--rounds 1000] [--first 0]

Genus meshes the tree to a tolerance of 1/200 of its diagonal; manifold3d combines the leaves, each
meshed to an eighth of that. Where V - E + F differs, both are asked again, eight times finer. Each
difference is printed with the reason: the solid touches itself along edges or in points, so that
its form hangs on a hair; or without specks, parts smaller than the tolerance each way, the forms
agree; or the finer forms do; or none of these. Exit status 1 if any is of the last kind.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass

import genus
import manifold3d
import numpy as np
from rounds import run_rounds

COARSE = 1 / 200  # of the diagonal
FINER = 1 / 8

Matrix = np.ndarray


def random_map(dice: np.random.Generator) -> Matrix:
    """Turned, stretched by up to 1.6 either way, turned again and moved."""

    def turn() -> Matrix:
        q, r = np.linalg.qr(dice.normal(size=(3, 3)))
        return q * np.sign(np.diag(r))

    linear = turn() @ np.diag(1.6 ** dice.uniform(-1, 1, 3)) @ turn()
    whole = np.eye(4)
    whole[:3, :3] = linear
    whole[:3, 3] = dice.uniform(-0.8, 0.8, 3)
    return whole


def random_leaf(dice: np.random.Generator) -> genus.Solid:
    """Any kind, bounded, of size about 1, under a random map."""

    def size() -> float:
        return float(dice.uniform(0.3, 1.2))

    def polynomial(*coefficients: float) -> genus.Solid:
        return genus.quadric(coefficients, bounds=[[-1, -1, -1], [1, 1, 1]])

    def within(low: float, high: float) -> float:
        return float(dice.uniform(low, high))

    kinds: list[Callable[[], genus.Solid]] = [
        lambda: genus.sphere(size()),
        lambda: genus.ellipsoid(size(), size(), size()),
        lambda: genus.cylinder(within(0.5, 2), size(), center=True),
        lambda: genus.cone(within(0.5, 2), size(), center=True),
        lambda: genus.cylinder(within(0.5, 2), r1=size(), r2=size(), center=True),
        lambda: polynomial(1, within(0.5, 2), 0, 0, 0, 0, 0, 0, -1, -0.5),
        lambda: polynomial(1, 1, -within(0.3, 1), 0, 0, 0, 0, 0, 0, -within(0.1, 0.4)),
        lambda: polynomial(1, 1, -within(1, 2), 0, 0, 0, 0, 0, 0, within(0.05, 0.2)),
        lambda: polynomial(1, -within(0.5, 2), 0, 0, 0, 0, 0, 0, -1, 0),
        lambda: genus.sphere(1.2) & genus.half_space(dice.uniform(-2, 2, 3), within(-0.5, 0.5)),
        lambda: polynomial(1, -within(0.3, 3), 0, 0, 0, 0, 0, 0, 0, 0),
        lambda: polynomial(*dice.uniform(-1, 1, 10)),
        lambda: genus.torus(within(0.5, 1), within(0.1, 0.4)),
    ]
    return kinds[dice.integers(len(kinds))]().transform(random_map(dice))


@dataclass
class Step:
    """Applied to what is there already, from left to right."""

    operation: str
    leaf: genus.Solid


def random_tree(seed: int) -> list[Step]:
    """1 to 12 leaves."""
    dice = np.random.default_rng(seed)
    n = 1 + seed % 12
    return [Step("++-&"[dice.integers(4)] if i else "+", random_leaf(dice)) for i in range(n)]


def by_genus(tree: list[Step], tolerance: float) -> genus.Mesh:
    """The solid of the whole tree."""
    whole = tree[0].leaf
    for step in tree[1:]:
        match step.operation:
            case "+":
                whole = whole + step.leaf
            case "-":
                whole = whole - step.leaf
            case _:
                whole = whole & step.leaf
    return whole.mesh(tolerance, measure=False)


def as_manifold(mesh: genus.Mesh) -> manifold3d.Manifold:
    """The same faces."""
    return manifold3d.Manifold(
        manifold3d.Mesh64(
            vert_properties=np.array(mesh.vertices), tri_verts=np.array(mesh.faces, np.uint64)
        )
    )


def by_manifold(tree: list[Step], tolerance: float) -> manifold3d.Manifold:
    """Leaf by leaf."""
    whole = manifold3d.Manifold()
    for step in tree:
        leaf = as_manifold(step.leaf.mesh(tolerance, measure=False))
        match step.operation:
            case "+":
                whole = whole + leaf
            case "-":
                whole = whole - leaf
            case _:
                whole = whole ^ leaf
    return whole


def euler_of(result: manifold3d.Manifold) -> int:
    """V - E + F of all parts together."""
    return 0 if result.is_empty() else 2 - 2 * int(result.genus())


def without_specks(result: manifold3d.Manifold, tolerance: float) -> int:
    """V - E + F of the parts that are longer than the tolerance along some axis."""
    euler = 0
    for part in result.decompose():
        box = np.array(part.bounding_box()).reshape(2, 3)
        if (box[1] - box[0]).max() > tolerance:
            euler += euler_of(part)
    return euler


def touches_itself(mesh: genus.Mesh) -> bool:
    """Two vertices at one place."""
    return len(np.unique(np.asarray(mesh.vertices), axis=0)) < len(mesh.vertices)


def try_seed(seed: int) -> str:
    """The kind of outcome; a difference is explained on standard output."""
    tree = random_tree(seed)
    corners = np.concatenate([np.asarray(step.leaf.bounds()) for step in tree])
    tolerance = COARSE * float(np.linalg.norm(corners.max(axis=0) - corners.min(axis=0)))
    try:
        ours = by_genus(tree, tolerance)
        theirs = by_manifold(tree, tolerance * FINER)
        forms = ours.topology.euler if len(ours) else 0, euler_of(theirs)
        if forms[0] == forms[1]:
            return "agree"
        if touches_itself(ours):
            reason = "it touches itself"
        elif len(ours) and without_specks(as_manifold(ours), tolerance) == without_specks(
            theirs, tolerance
        ):
            reason = "specks below the tolerance"
        else:
            ours = by_genus(tree, tolerance * FINER)
            finer = (
                ours.topology.euler if len(ours) else 0,
                euler_of(by_manifold(tree, tolerance * FINER**2)),
            )
            agree = finer[0] == finer[1]
            reason = "features below the tolerance" if agree else f"still {finer[0]} and {finer[1]}"
    except genus.ToleranceNotMet as error:
        print(f"seed {seed} refused: {error}", flush=True)
        return "refused"
    print(f"seed {seed}: V - E + F is {forms[0]} and {forms[1]}: {reason}", flush=True)
    return reason if not reason.startswith("still") else "differ"


if __name__ == "__main__":
    sys.exit(run_rounds(try_seed, __doc__, 1000, "differ"))
