"""The constrained Delaunay triangulation beside CGAL's, on polygons in general position."""

import genus
import numpy as np
import pytest

CGAL = pytest.importorskip(
    "CGAL.CGAL_Triangulation_2", reason="CGAL is not installed (pip install cgal)"
)
Point = pytest.importorskip("CGAL.CGAL_Kernel", reason="CGAL is not installed").Point_2


def star(random, n, center, low, high):
    angle = (np.arange(n) + random.uniform(-0.3, 0.3, n)) * (2 * np.pi / n)
    r = random.uniform(low, high, n)
    return np.column_stack([center[0] + r * np.cos(angle), center[1] + r * np.sin(angle)])


def polygon_with_holes(seed):
    """A star with up to three holes; with even seeds two of them touch in a point."""
    random = np.random.default_rng(seed)
    outer = star(random, int(random.integers(24, 80)), (0, 0), 8, 14)
    left = star(random, int(random.integers(5, 20)), (-3, 0), 1, 2.4)
    right = star(random, int(random.integers(5, 20)), (3, 0), 1, 2.4)
    if seed % 2 == 0:
        touch = random.uniform(-0.2, 0.2, 2)
        right[len(right) // 2] = left[0] = touch
    above = star(random, 7, (0, 5), 0.5, 1.5)
    return outer, [left, right, above][: 1 + seed % 3]


def inside(rings, p):
    """Whether points lie within an odd number of rings."""
    odd = np.zeros(len(p), bool)
    for ring in rings:
        for a, b in zip(ring, np.roll(ring, -1, 0), strict=True):
            spans = (a[1] > p[:, 1]) != (b[1] > p[:, 1])
            with np.errstate(divide="ignore", invalid="ignore"):
                x = a[0] + (p[:, 1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1])
            odd ^= spans & (p[:, 0] < x)
    return odd


def by_cgal(rings):
    cdt = CGAL.Constrained_Delaunay_triangulation_2()
    for ring in rings:
        handles = [cdt.insert(Point(float(x), float(y))) for x, y in ring]
        for a, b in zip(handles, handles[1:] + handles[:1], strict=True):
            cdt.insert_constraint(a, b)
    corners = np.array(
        [
            [(f.vertex(i).point().x(), f.vertex(i).point().y()) for i in range(3)]
            for f in cdt.finite_faces()
        ]
    )
    return corners[inside(rings, corners.mean(axis=1))]


def as_set(triangles):
    return {tuple(sorted(map(tuple, t.tolist()))) for t in triangles}


@pytest.mark.parametrize("seed", range(30))
def test_the_same_triangles_as_cgal(seed):
    outer, holes = polygon_with_holes(seed)
    points = np.vstack([outer, *holes])
    triangles = points[genus.triangulate(outer, holes, "delaunay")]
    theirs = by_cgal([outer, *holes])
    assert len(triangles) == len(theirs)
    assert as_set(triangles) == as_set(theirs)
    touching = len(points) - len(np.unique(points, axis=0))
    assert len(triangles) == len(points) - 2 + 2 * len(holes) - 2 * touching
