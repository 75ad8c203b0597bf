"""Curves, patches, deformation and its inverse: what theory promises, and second opinions."""

import itertools
import math
import os
import shutil
import subprocess
from fractions import Fraction
from pathlib import Path

import genus
import numpy as np
import pytest

LONG = os.environ.get("GENUS_LONG") == "1"


def bernstein(n: int, t: np.ndarray) -> np.ndarray:
    return np.array([math.comb(n, k) * t**k * (1 - t) ** (n - k) for k in range(n + 1)])


def exact_value(points: np.ndarray, t: float) -> list[Fraction]:
    """De Casteljau in rational numbers: no rounding at all."""
    s = Fraction(t)
    p = [[Fraction(c) for c in row] for row in points.tolist()]
    while len(p) > 1:
        p = [
            [(1 - s) * a + s * b for a, b in zip(x, y, strict=True)]
            for x, y in itertools.pairwise(p)
        ]
    return p[0]


def net(rng: np.random.Generator, m: int, n: int, bump: float = 0.5) -> np.ndarray:
    """A gently curved sheet over [0, 1]^2."""
    x, y = np.meshgrid(np.linspace(0, 1, m + 1), np.linspace(0, 1, n + 1), indexing="ij")
    return np.stack([x, y, bump * rng.standard_normal((m + 1, n + 1))], axis=-1)


# ---- Curves


def test_curve_values_are_those_of_the_bernstein_basis():
    rng = np.random.default_rng(1)
    t = np.linspace(0, 1, 1001)
    for degree in (0, 1, 3, 20):
        points = rng.standard_normal((degree + 1, 3))
        curve = genus.BezierCurve(points)
        np.testing.assert_allclose(curve.evaluate(t), bernstein(degree, t).T @ points, atol=1e-12)
        assert curve.degree == degree
        assert np.array_equal(curve.points, points)
        assert not curve.points.flags.writeable


def test_parameters_keep_their_shape():
    curve = genus.BezierCurve([[0, 0, 0], [1, 2, 0], [2, 0, 0]])
    assert curve.evaluate(0.5).shape == (3,)
    assert curve.evaluate([[0.1, 0.2, 0.3]]).shape == (1, 3, 3)
    patch = genus.TensorPatch(net(np.random.default_rng(2), 3, 2))
    u, v = np.linspace(0, 1, 7)[:, None], np.linspace(0, 1, 5)
    assert patch.evaluate(u, v).shape == (7, 5, 3)
    assert patch.normals(u, v).shape == (7, 5, 3)
    with pytest.raises(ValueError, match="shape"):
        genus.BezierCurve([1, 2, 3])
    with pytest.raises(ValueError, match="must be"):
        genus.BezierCurve([[0, 0, 0]], weights=[-1])


def test_split_elevate_and_derivative_agree_with_the_curve():
    rng = np.random.default_rng(3)
    curve = genus.BezierCurve(rng.standard_normal((6, 3)))
    t = np.linspace(0, 1, 101)
    low, high = curve.split(0.3)
    np.testing.assert_allclose(low.evaluate(t), curve.evaluate(0.3 * t), atol=1e-13)
    np.testing.assert_allclose(high.evaluate(t), curve.evaluate(0.3 + 0.7 * t), atol=1e-13)
    np.testing.assert_allclose(curve.elevate(3).evaluate(t), curve.evaluate(t), atol=1e-13)
    h = 1e-5
    slope = (curve.evaluate(t[1:-1] + h) - curve.evaluate(t[1:-1] - h)) / (2 * h)
    np.testing.assert_allclose(curve.derivative(t[1:-1]), slope, atol=1e-8)
    assert np.array_equal(curve.derivative(0.5, order=6), np.zeros(3))


def test_rounding_bounds_hold_against_exact_arithmetic():
    """Degree 40, sizes from 1e-12 to 1e12, Wilkinson's roots: bound >= error, at most 10 times it
    in the median. GENUS_LONG=1 takes a million points, against 256 bits."""
    rng = np.random.default_rng(4)
    ratios, checked = [], 0
    wilkinson = np.array([1.0])
    for k in range(1, 21):
        wilkinson = np.convolve(wilkinson, [1.0, -k / 20])
    power = wilkinson[::-1]
    coefficients = [
        sum(power[i] * math.comb(k, i) / math.comb(20, i) for i in range(k + 1)) for k in range(21)
    ]
    sets = [np.stack([coefficients, coefficients[::-1], np.zeros(21)], axis=1)]
    for _ in range(200 if LONG else 8):
        sizes = 10.0 ** rng.uniform(-12, 12, (41, 3))
        sets.append(sizes * rng.choice([-1.0, 1.0], (41, 3)))
    per_set = 1700 if LONG else 6
    for points in sets:
        curve = genus.BezierCurve(points)
        parameters = rng.uniform(0, 1, per_set)
        exact = exact_many(points, parameters) if LONG else None
        for i, t in enumerate(parameters):
            value, bound = curve.value_with_bound(t)
            truth = exact[i] if LONG else exact_value(points, t)
            for v, b, x in zip(value, bound, truth, strict=True):
                error = abs(Fraction(v) - x)
                assert error <= Fraction(b)
                checked += 1
                if error > 0:
                    ratios.append(float(Fraction(b) / error))
    assert checked > 100
    assert np.median(ratios) <= 10
    print(f"{checked} coordinates, median bound / error {np.median(ratios):.3g}")


def exact_many(points: np.ndarray, parameters: np.ndarray) -> list[list[Fraction]]:
    """256-bit evaluation by the basis, the sum of positive and negative terms apart."""
    mpmath = pytest.importorskip("mpmath", reason="the long test needs mpmath")
    mpmath.mp.prec = 256
    n = len(points) - 1
    p = [[mpmath.mpf(c) for c in row] for row in points.tolist()]
    result = []
    for t in parameters.tolist():
        s, r = mpmath.mpf(t), 1 - mpmath.mpf(t)
        b = [math.comb(n, k) * s**k * r ** (n - k) for k in range(n + 1)]
        values = [mpmath.fsum(b[k] * p[k][d] for k in range(n + 1)) for d in range(3)]
        result.append(
            [Fraction(*map(int, v.as_integer_ratio())) if v else Fraction(0) for v in values]
        )
    return result


def test_flattening_keeps_its_bound_and_order():
    curve = genus.BezierCurve([[0, 0, 0], [0, 3, 1], [4, 3, -1], [4, 0, 2]])
    fine = curve.evaluate(np.linspace(0, 1, 20001))
    counts = []
    for tolerance in (1e-2, 1e-4, 1e-6):
        line = curve.flatten(tolerance)
        assert line.bound <= tolerance
        assert len(line) == len(line.parameters)
        p = np.asarray(line)
        k = np.clip(np.searchsorted(line.parameters, np.linspace(0, 1, 20001)) - 1, 0, len(p) - 2)
        a, d = p[k], p[k + 1] - p[k]
        s = np.clip(((fine - a) * d).sum(1) / (d * d).sum(1), 0, 1)
        assert np.linalg.norm(a + s[:, None] * d - fine, axis=1).max() <= line.bound * (1 + 1e-9)
        counts.append(len(line))
    # A hundredth of the tolerance needs ten times the points.
    assert 6 < counts[1] / counts[0] < 16
    assert 6 < counts[2] / counts[1] < 16


def test_subdivision_converges_quadratically():
    """The distance from control polygon to curve falls fourfold a halving."""
    points = np.random.default_rng(5).standard_normal((8, 3))
    pieces, gaps = [genus.BezierCurve(points)], []
    for _ in range(10):
        gap = 0.0
        for c in pieces:
            # Greville's places: the points stand over k / n.
            t = np.arange(c.degree + 1) / c.degree
            gap = max(gap, np.linalg.norm(c.evaluate(t) - c.points, axis=1).max())
        gaps.append(gap)
        pieces = [half for c in pieces for half in c.split(0.5)]
    orders = np.log2(np.array(gaps[:-1]) / np.array(gaps[1:]))
    assert np.all(orders[-2:] > 1.9)
    assert np.all(orders[-2:] < 2.1)


def test_splines_interpolate_and_agree_with_scipy():
    interpolate = pytest.importorskip("scipy.interpolate", reason="scipy is the second opinion")
    rng = np.random.default_rng(6)
    points = rng.standard_normal((12, 3))
    spline = genus.interpolate(points, parametrization="uniform")
    t = np.linspace(*spline.domain, 500)
    ours = spline.evaluate(t)
    theirs = interpolate.CubicSpline(np.linspace(*spline.domain, 12), points, bc_type="not-a-knot")
    np.testing.assert_allclose(ours, theirs(t), atol=1e-10)
    general = genus.BSpline(points, 4)
    peer = interpolate.BSpline(general.knots, points, 4)
    t = np.linspace(0, 1, 500, endpoint=False)
    np.testing.assert_allclose(general.evaluate(t), peer(t), atol=1e-12)
    np.testing.assert_allclose(general.derivative(t, 2), peer.derivative(2)(t), atol=1e-9)
    with pytest.raises(genus.InvalidInput, match="split: t"):
        general.split(0.0)
    low, high = general.split(0.37)
    assert low.domain == (0.0, 0.37)
    assert high.domain == (0.37, 1.0)
    np.testing.assert_allclose(low.evaluate([0.1, 0.37]), general.evaluate([0.1, 0.37]), atol=1e-12)
    np.testing.assert_allclose(
        high.evaluate([0.37, 0.9]), general.evaluate([0.37, 0.9]), atol=1e-12
    )


def test_circles_and_spheres_are_exact():
    circle = genus.elliptic_arc([1, 2, 3], [2, 0, 0], [0, 2, 0])
    p = circle.evaluate(np.linspace(*circle.domain, 999)) - [1, 2, 3]
    np.testing.assert_allclose(np.hypot(p[:, 0], p[:, 1]), 2, atol=1e-14)
    half = genus.elliptic_arc([0, 0, 0], [0, 0, -1], [1, 0, 0], sweep=180)
    ball = genus.surface_of_revolution(half)
    u, v = np.random.default_rng(7).uniform(0, 1, (2, 1000))
    p, n = ball.points_and_normals(u, v)
    np.testing.assert_allclose(np.linalg.norm(p, axis=1), 1, atol=1e-14)
    np.testing.assert_allclose(np.abs((p * n).sum(1)), 1, atol=1e-12)
    mesh = ball.mesh(1e-3)
    assert mesh.is_closed
    assert mesh.error.measured <= mesh.error.bound <= 1e-3
    assert abs(mesh.volume) == pytest.approx(4 / 3 * math.pi, rel=5e-3)


# ---- Patches


def test_patch_values_normals_and_splits():
    rng = np.random.default_rng(8)
    u, v = rng.uniform(0, 1, (2, 400))
    for m, n in ((1, 1), (3, 3), (2, 5)):
        points = net(rng, m, n)
        patch = genus.TensorPatch(points)
        expected = np.einsum("ik,jk,ijx->kx", bernstein(m, u), bernstein(n, v), points)
        np.testing.assert_allclose(patch.evaluate(u, v), expected, atol=1e-13)
        normals = patch.normals(u, v)
        for k in range(0, 400, 80):
            d = patch.partials(u[k], v[k])
            cross = np.cross(d["u"], d["v"])
            np.testing.assert_allclose(normals[k], cross / np.linalg.norm(cross), atol=1e-10)
        parts = patch.split(0.25, 0.5)
        assert len(parts) == 4
        np.testing.assert_allclose(
            parts[3].evaluate(u, v), patch.evaluate(0.25 + 0.75 * u, 0.5 + 0.5 * v), atol=1e-13
        )


def test_triangle_values_are_those_of_the_basis():
    rng = np.random.default_rng(9)
    n = 4
    points = rng.standard_normal((15, 3))
    patch = genus.TrianglePatch(points, n)
    u, v = np.sort(rng.uniform(0, 1, (2, 300)), axis=0)
    v = v - u
    w = 1 - u - v
    expected, row = np.zeros((300, 3)), 0
    for i in range(n + 1):
        for j in range(n + 1 - i):
            k = n - i - j
            c = math.factorial(n) // (math.factorial(i) * math.factorial(j) * math.factorial(k))
            expected += (c * u**i * v**j * w**k)[:, None] * points[row]
            row += 1
    np.testing.assert_allclose(patch.evaluate(u, v), expected, atol=1e-13)
    with pytest.raises(ValueError, match="number of points"):
        genus.TrianglePatch(points, 3)


def test_tessellation_error_falls_fourfold_a_doubling():
    """Quadratic in the cells: a quarter of the tolerance, twice as many cells a side."""
    patch = genus.TensorPatch(net(np.random.default_rng(10), 3, 3, 0.3))
    triangles, measured = [], []
    for tolerance in (4e-3, 1e-3, 2.5e-4, 6.25e-5):
        mesh = patch.mesh(tolerance)
        assert mesh.error.certified
        assert mesh.error.measured <= mesh.error.bound <= tolerance
        triangles.append(len(mesh))
        measured.append(mesh.error.measured)
    assert np.all(np.abs(np.log2(np.array(triangles[1:]) / triangles[:-1]) - 2) < 0.5)
    orders = -np.log(np.array(measured[1:]) / measured[:-1]) / np.log(np.sqrt(4.0))
    assert np.all(np.abs(orders[1:] - 2) < 0.5)


def neighbours(rng: np.random.Generator) -> genus.PatchModel:
    """Two patches with one border curve in common: tensor or triangle, of different degrees."""
    degree = int(rng.integers(1, 5))
    border = np.stack(
        [np.linspace(0, 1, degree + 1), np.zeros(degree + 1), rng.standard_normal(degree + 1)],
        axis=1,
    )

    def patch(side: float):
        if rng.uniform() < 0.5:
            rows = int(rng.integers(1, 4))
            points = np.stack([border + [0, side * k / rows, 0] for k in range(rows + 1)])
            points[1:, :, 2] += 0.3 * rng.standard_normal((rows, degree + 1))
            if rng.uniform() < 0.5:
                points = points[:, ::-1]
            p = genus.TensorPatch(points)
            return p.elevate(0, int(rng.integers(0, 3)))
        points = []
        for i in range(degree + 1):
            row = border[: degree + 1 - i] + [0.5 * i / degree, side * i / degree, 0]
            points += [q + [0, 0, 0.3 * rng.standard_normal() * (i > 0)] for q in row]
        p = genus.TrianglePatch(np.array(points), degree)
        return p.elevate(int(rng.integers(0, 3)))

    return genus.PatchModel([patch(1.0), patch(-1.0)])


def test_neighbours_have_no_crack():
    """Random pairs, tensor or triangle, at all tolerances: every vertex on the common border is
    shared. GENUS_LONG=1 takes 10,000 pairs."""
    rng = np.random.default_rng(11)
    kinds = set()
    for case in range(10_000 if LONG else 40):
        model = neighbours(rng)
        kinds.add(tuple(sorted(type(p).__name__ for p in model.patches)))
        mesh = model.mesh(10.0 ** rng.uniform(-3.5 if LONG else -2.5, 0), measure=False)
        topology = mesh.topology
        # One sheet with one border: V - E + F = 1. A crack would be a second border, or a slit.
        assert (topology.components, topology.boundary_loops, topology.euler) == (1, 1, 1), case
        assert topology.manifold, case
        assert np.bincount(mesh.faces.ravel()).min() > 0, case
        # Bits of the coordinates mixed into one number: different numbers, different places.
        bits = (mesh.vertices + 0.0).view(np.uint64) * np.array([1, 2654435761, 40503], np.uint64)
        mixed = np.bitwise_xor.reduce(bits * np.uint64(0x9E3779B97F4A7C15), axis=1)
        assert len(np.unique(mixed)) == len(mesh.vertices), case
    assert len(kinds) == 3


def test_pn_triangles_of_a_ball_are_closed():
    ball = genus.sphere(1).mesh(0.05)
    model = genus.PatchModel.pn_triangles(ball, ball.vertices)
    assert model.is_closed
    assert model.is_oriented
    assert len(model) == len(ball)
    mesh = model.mesh(0.01)
    assert mesh.is_closed
    assert np.abs(np.linalg.norm(mesh.vertices, axis=1) - 1).max() < 0.01


# ---- The teapot


@pytest.fixture(scope="module")
def teapot(models):
    return genus.load_patches(models / "patches" / "teapot.bpt")


def test_the_teapot_is_closed(teapot):
    assert len(teapot) == 42
    assert teapot.is_closed
    assert teapot.is_oriented
    assert max(j["gap"] for j in teapot.joins()) < 1e-14
    mesh = teapot.mesh(0.01)
    topology = mesh.topology
    # Body with lid, handle and spout: three balls; the handle touches the wall in one point that
    # is a corner of both.
    assert (topology.components, topology.euler) == (2, 5)
    assert topology.closed
    assert topology.oriented
    assert mesh.error.certified
    assert mesh.error.measured <= mesh.error.bound <= 0.01


def test_the_teapot_in_booleans(teapot):
    pot = genus.solid(teapot)
    mesh = pot.mesh(0.01)
    # The handle makes a ring; the spout is filled.
    assert (mesh.topology.components, mesh.topology.genus) == (1, 1)
    assert mesh.validate() == []
    assert mesh.error.bound <= 0.01
    ball = genus.sphere(1.2).translate([0, 0, 1.2])
    cut = (pot - ball).mesh(0.01)
    assert cut.validate() == []
    inner = (pot & ball).mesh(0.01)
    both = cut.volume + inner.volume
    assert both == pytest.approx(mesh.volume, abs=0.01 * (cut.area + inner.area + mesh.area))
    finer = genus.solid(teapot.mesh(0.002))
    assert (finer - ball).mesh(0.01).error.bound >= teapot.mesh(0.002).error.bound


def test_spline_surfaces_split_and_take_knots():
    rng = np.random.default_rng(15)
    for weights in (None, rng.uniform(0.5, 2, (6, 5))):
        s = genus.BSplineSurface(rng.standard_normal((6, 5, 3)), (3, 2), weights=weights)
        parts = s.split(u=0.4, v=1 / 3)  # one inside a span, one at a knot
        assert len(parts) == 4
        u, v = rng.uniform(0, 1, (2, 200))
        which = 2 * (u >= 0.4) + (v >= 1 / 3)
        for k, part in enumerate(parts):
            np.testing.assert_allclose(
                part.evaluate(u[which == k], v[which == k]),
                s.evaluate(u[which == k], v[which == k]),
                atol=1e-12,
            )
        more = s.insert_knot(u=0.4).insert_knot(v=0.9)
        assert more.points.shape == (7, 6, 3)
        np.testing.assert_allclose(more.evaluate(u, v), s.evaluate(u, v), atol=1e-12)
    for bad in (0, 1, 2, math.nan):
        with pytest.raises(genus.InvalidInput):
            s.split(u=bad)
        with pytest.raises(genus.InvalidInput):
            s.insert_knot(v=bad)
    with pytest.raises(genus.InvalidInput, match="give u, v or both"):
        s.split()


def test_patch_files_round_trip_and_name_their_faults(tmp_path, teapot):
    path = tmp_path / "all.bpt"
    rng = np.random.default_rng(12)
    model = genus.PatchModel(
        [
            genus.TensorPatch(net(rng, 2, 3)),
            genus.TensorPatch(net(rng, 1, 1), weights=[[1, 2], [3, 4]]),
            genus.TrianglePatch(rng.standard_normal((6, 3)), weights=np.arange(1, 7)),
        ]
    )
    model.save(path)
    again = genus.load_patches(path)
    for a, b in zip(model.patches, again.patches, strict=True):
        assert type(a) is type(b)
        assert np.array_equal(a.points, b.points)
        assert (a.weights is None) == (b.weights is None)
        assert a.weights is None or np.array_equal(a.weights, b.weights)
    lines = path.read_text().splitlines()
    faults = {
        "4\n": (1, None),  # one patch more than there is
        "ends": lines[:-1],
        "point 3 of patch 1 of 3": [*lines[:4], "1 2", *lines[5:]],
        "degree": [lines[0], "2.5 3", *lines[2:]],
        "unexpected": [*lines, "7"],
    }
    for text, given in faults.items():
        bad = tmp_path / "bad.bpt"
        content = "\n".join(given if isinstance(given, list) else ["4", *lines[1:]])
        bad.write_text(content)
        with pytest.raises(genus.FileError) as caught:
            genus.load_patches(bad)
        assert caught.value.line is not None
        assert text == "4\n" or text in str(caught.value)
    for cut in range(0, len(path.read_bytes()), 37):
        (tmp_path / "cut.bpt").write_bytes(path.read_bytes()[:cut])
        with pytest.raises(genus.FileError):
            genus.load_patches(tmp_path / "cut.bpt")


def alike(model, again, exact=True):
    assert len(model) == len(again)
    for a, b in zip(model.patches, again.patches, strict=True):
        assert type(a) is type(b)
        assert a.degree == b.degree
        assert (a.weights is None) == (b.weights is None)
        for x, y in [(a.points, b.points), (a.weights, b.weights)]:
            if x is not None and exact:
                np.testing.assert_array_equal(x, y)
            elif x is not None:
                np.testing.assert_allclose(x, y, rtol=1e-15, atol=1e-15)


def test_patches_go_through_other_formats(tmp_path):
    rng = np.random.default_rng(13)
    plain = [genus.TensorPatch(net(rng, 2, 3)), genus.TensorPatch(net(rng, 2, 3))]
    rational = [
        genus.TensorPatch(net(rng, 2, 3), weights=rng.uniform(0.5, 2, (3, 4))) for _ in range(2)
    ]
    other = [genus.TensorPatch(net(rng, 1, 4))]
    triangle = [genus.TrianglePatch(rng.standard_normal((10, 3)))]
    for name, patches in [
        ("a.bv", plain + other + triangle),
        ("a.obj", plain + rational + other),
        ("a.bez", plain),
        ("a.bez", rational),
        ("a.BBP", plain),
    ]:
        model = genus.PatchModel(patches)
        model.save(tmp_path / name)
        exact = not (name == "a.bez" and patches is rational)
        alike(model, genus.load_patches(tmp_path / name), exact)
    for name, patches, why in [
        ("b.bv", rational, "has weights"),
        ("b.obj", triangle, "is a triangle"),
        ("b.bez", plain + other, "other degrees"),
        ("b.bez", triangle, "is a triangle"),
        ("b.bez", [genus.TensorPatch(net(rng, 7, 1))], "degree"),
    ]:
        with pytest.raises(genus.InvalidInput, match=why):
            genus.PatchModel(patches).save(tmp_path / name)
        assert not (tmp_path / name).exists()


def test_newells_own_form_is_read(tmp_path, teapot):
    """The first patches of the teapot, with points numbered from 1 and commas."""
    few = teapot.patches[:3]
    points = np.unique(np.concatenate([p.points.reshape(-1, 3) for p in few]), axis=0)
    number = {tuple(p): k + 1 for k, p in enumerate(points.tolist())}
    lines = [str(len(few))]
    lines += [
        ",".join(str(number[tuple(x)]) for x in p.points.reshape(-1, 3).tolist()) for p in few
    ]
    lines += [str(len(points))]
    lines += [",".join(map(repr, p)) for p in points.tolist()]
    path = tmp_path / "teapot"
    path.write_text("\r\n".join(lines))
    alike(genus.PatchModel(few), genus.load_patches(path))
    bad = lines.copy()
    bad[2] = bad[2].replace(",", ",9", 1)
    path.write_text("\n".join(bad))
    with pytest.raises(genus.FileError, match="there is no point 9") as caught:
        genus.load_patches(path)
    assert caught.value.line == 3


OBJ = """# two spans of a rational spline, of which the left one and half of the right are meant
{vertices}
cstype rat bspline
deg 2 1
surf 0 1.5 0 1 1 2/1 3//1 -5 \\
  5 6 7 8
parm u 0 0 0 1 2 2 2
parm v 0 0 1 1
end
"""


def test_free_form_surfaces_of_obj_files(tmp_path):
    rng = np.random.default_rng(14)
    points, weights = rng.standard_normal((4, 2, 3)), rng.uniform(0.5, 2, (4, 2))
    rows = [[*points[i, j], weights[i, j]] for j in range(2) for i in range(4)]
    vertices = "\n".join("v " + " ".join(map(repr, map(float, r))) for r in rows)
    path = tmp_path / "a.obj"
    path.write_text(OBJ.format(vertices=vertices))
    model = genus.load_patches(path)
    surface = genus.BSplineSurface(
        points, (2, 1), knots=([0, 0, 0, 1, 2, 2, 2], [0, 0, 1, 1]), weights=weights
    )
    u, v = rng.uniform(0, 1, (2, 50))
    for k, (start, length) in enumerate([(0, 1), (1, 0.5)]):
        np.testing.assert_allclose(
            model.patches[k].evaluate(u, v), surface.evaluate(start + length * u, v), atol=1e-12
        )
    assert len(model) == 2
    text = path.read_text()
    for old, new, why, line in [
        ("deg 2 1", "deg 2", "two degrees", 12),
        ("-5", "-9", "no vertex -9", 12),
        ("parm v 0 0 1 1", "parm v 0 1 1", "knot", 12),
        ("bspline", "cardinal", "bezier and bspline", 12),
        ("end", "trim 0 1 1\nend", "trimmed", 16),
        ("end", "", "no end", 12),
        ("0 1.5 0 1", "0 0 0 1", "range", 12),
        ("end", "end\nf 1 2 3", "polygons", 17),
        ("7 8", "7", "control points", 12),
    ]:
        path.write_text(text.replace(old, new))
        with pytest.raises(genus.FileError, match=why) as caught:
            genus.load_patches(path)
        assert caught.value.line == line, why
    for cut in range(0, len(text), 23):
        path.write_text(text[:cut])
        with pytest.raises(genus.FileError):
            genus.load_patches(path)


def test_open_patches_are_no_solid():
    sheet = genus.PatchModel([genus.TensorPatch(net(np.random.default_rng(13), 3, 3))])
    with pytest.raises(genus.InvalidInput, match="open at edge"):
        genus.solid(sheet)


# ---- Deformation


def bent_lattice(seed: int, degree=(3, 3, 3), amount: float = 0.25) -> genus.Lattice:
    """Inner control points moved, the border at rest."""
    lattice = genus.Lattice([-2, -2, -2], np.eye(3) * 4, degree=degree)
    rng = np.random.default_rng(seed)
    inner = lattice.points[1:-1, 1:-1, 1:-1]
    inner += amount * rng.uniform(-1, 1, inner.shape)
    return lattice


def test_ffd_is_the_sum_over_the_basis():
    rng = np.random.default_rng(14)
    for degree in ((1, 2, 3), (7, 7, 7), (3, 3, 3)):
        axes = np.eye(3) + 0.2 * rng.standard_normal((3, 3))
        lattice = genus.Lattice([1, 2, 3], axes, degree=degree)
        rest = lattice.points.copy()
        lattice.points = rest + 0.1 * rng.standard_normal(rest.shape)
        s = rng.uniform(0, 1, (500, 3))
        x = [1, 2, 3] + s @ axes
        basis = [bernstein(n, s[:, k]) for k, n in enumerate(degree)]
        expected = np.einsum("ip,jp,kp,ijkx->px", *basis, lattice.points)
        np.testing.assert_allclose(lattice.apply(x), expected, atol=1e-12)
    lattice = genus.Lattice([0, 0, 0], np.eye(3))
    assert np.array_equal(lattice.apply(x), x)  # at rest the identity, to the last bit


def test_points_of_a_lattice_may_be_written_to():
    lattice = genus.Lattice([0, 0, 0], np.eye(3), degree=(2, 2, 2))
    lattice.points[1, 1, 1] += [0, 0, 0.5]
    assert lattice.apply([0.5, 0.5, 0.5])[2] == pytest.approx(0.5 + 0.5 / 8)
    lattice.points[1, 1, 1, 2] = math.nan
    with pytest.raises(genus.InvalidInput, match="not finite"):
        lattice.apply([0.5, 0.5, 0.5])


def test_inverse_undoes_the_lattice():
    lattice = bent_lattice(15)
    x = np.random.default_rng(16).uniform(-2.2, 2.2, (300, 3))
    back = lattice.inverse_details(lattice.apply(x))
    assert back["found"].all()
    assert back["certified"].mean() > 0.95
    np.testing.assert_allclose(back["points"], x, atol=1e-10)
    assert lattice.folds().kind == "none"
    folded = genus.Lattice([0, 0, 0], np.eye(3), degree=(3, 3, 3))
    folded.points[1], folded.points[2] = folded.points[2].copy(), folded.points[1].copy()
    folded.points[1, 1:3, 1:3, 0] += 3
    report = folded.folds()
    assert report.kind == "folded"
    assert report.determinant < 0
    assert np.linalg.det(folded.jacobian(report.where)) < 0
    with pytest.raises(genus.InvalidInput, match="inside out"):
        genus.cube(1).deform(folded).mesh(0.01)


def test_affine_lattices_act_on_control_points():
    lattice = genus.Lattice([0, 0, 0], np.eye(3), degree=(1, 1, 1))
    matrix = np.array([[1, 0.2, 0], [0, 1, 0.1], [0.3, 0, 1]])
    lattice.points = lattice.points @ matrix.T + [0.1, 0.2, 0.3]
    patch = genus.TensorPatch(net(np.random.default_rng(17), 3, 3, 0.1) * 0.5 + [0, 0, 0.5])
    u, v = np.random.default_rng(18).uniform(0, 1, (2, 100))
    np.testing.assert_allclose(
        lattice.apply(patch).evaluate(u, v), lattice.apply(patch.evaluate(u, v)), atol=1e-12
    )


def test_a_deformed_solid_by_two_ways():
    """Through the mesh and through the inverse map by extended marching cubes, both with a proven
    bound: they agree within their bounds."""
    lattice = bent_lattice(19, amount=0.4)
    bored = genus.sphere(1.2) - genus.cylinder(h=4, r=0.5, center=True)
    tolerance = 0.05
    for part, holes in [(bored, 1)]:
        solid = part.deform(lattice)
        through_mesh = solid.mesh(tolerance)
        through_inverse = solid.mesh(2 * tolerance, method="emc")
        for mesh, asked in [(through_mesh, tolerance), (through_inverse, 2 * tolerance)]:
            assert mesh.error.certified
            assert mesh.error.measured <= mesh.error.bound <= asked
            assert mesh.validate() == []
            assert mesh.topology.genus == holes
        apart = through_mesh.distance(through_inverse).max
        assert 0 < apart <= through_mesh.error.bound + through_inverse.error.bound
        assert abs(through_mesh.volume - through_inverse.volume) <= apart * through_mesh.area


def test_questions_to_deformed_solids_and_patches(teapot):
    """By the inverse map where there is one, else by a mesh within 1/4096 of the diagonal."""
    rng = np.random.default_rng(31)
    lattice = bent_lattice(19, amount=0.4)
    part = genus.cube(1.6, center=True) - genus.sphere(0.7)
    solid = part.deform(lattice)
    x = rng.uniform(-1.2, 1.2, (500, 3))
    y = lattice.apply(x)
    np.testing.assert_array_equal(solid.contains(y), part.contains(x))
    np.testing.assert_allclose(solid.value(y), part.value(x), atol=1e-9)
    # Derivative along any way: that of the function before, by the chain rule.
    d = 1e-6 * rng.standard_normal((500, 3))
    slope = (solid.value(y + d) - solid.value(y - d)) / 2
    good = np.abs(slope - (solid.gradient(y) * d).sum(1)) < 1e-3 * np.linalg.norm(d, axis=1)
    assert good.mean() > 0.98  # all but those next to a crease
    hits = solid.ray_cast([[-5, 0.1, 0.1]] * 2, [[1, 0, 0], [1, 0.01, 0]])
    assert len(hits) >= 4
    assert np.abs(solid.value(hits.points)).max() < 1e-9
    both = solid | genus.sphere(0.3).translate([3, 0, 0])
    assert both.contains([[3, 0, 0.2], [3, 0, 0.4]]).tolist() == [True, False]

    pot = genus.solid(teapot)
    mesh = pot.mesh(0.01)
    points = rng.uniform(*mesh.bounds, (300, 3))
    clear = mesh.nearest(points)[1] > 0.02
    np.testing.assert_array_equal(pot.contains(points)[clear], mesh.contains(points)[clear])


def test_deformed_solids_go_into_booleans():
    lattice = bent_lattice(20)
    bent = genus.cube(2, center=True).deform(lattice)
    cut = (bent - genus.cylinder(h=5, r=0.4, center=True)).mesh(0.02)
    assert cut.validate() == []
    assert cut.topology.genus == 1
    assert cut.error.bound <= 0.02
    moved = bent.translate([10, 0, 0]).mesh(0.02)
    assert moved.error.certified
    assert moved.bounds[0, 0] > 8


def test_a_boolean_of_curved_parts_is_certified_where_they_cross_at_an_angle():
    """The bound holds against the closed form; a touch is not called proven."""
    rest = genus.Lattice([-2, -2, -2], 4 * np.eye(3), degree=(1, 1, 1))
    ball = genus.sphere(1).deform(rest)  # meshed by itself, so that a boolean has to join it
    cut = (ball - genus.cube([0.5, 0.5, 3])).mesh(0.02)
    assert cut.error.certified
    assert cut.error.measured <= cut.error.bound <= 0.02
    radius = np.linalg.norm(cut.vertices, axis=1)
    assert radius.max() <= 1 + cut.error.bound
    # The corner of the notch on the axis, and its edge at the corner of the cube on the ball.
    edge = np.array([0.5, 0.5, math.sqrt(0.5)])
    assert np.linalg.norm(cut.vertices - edge, axis=1).min() <= cut.error.bound
    touch = (ball | genus.sphere(1).translate([1.9999, 0, 0])).mesh(0.01)
    assert not touch.error.certified


@pytest.mark.parametrize("tolerance", [0.05, 0.01])
def test_two_balls_are_certified_at_any_angle_that_is_not_small(tolerance):
    """Their lens, union and difference, meshed on their own and joined: at 60, 90 and 37 degrees.
    The tip of the lens and its rim are where geometry says."""
    rest = genus.Lattice([-2, -2, -2], 4 * np.eye(3), degree=(1, 1, 1))
    ball = genus.sphere(1).deform(rest)
    for apart in (1.0, math.sqrt(2), 1.9):
        other = genus.sphere(1).translate([apart, 0, 0])
        for solid in (ball & other, ball | other, ball - other):
            mesh = solid.mesh(tolerance)
            assert mesh.error.certified, mesh.error.doubt
            assert mesh.error.doubt == ""
            assert mesh.error.measured <= mesh.error.bound <= tolerance
            near = np.abs(np.linalg.norm(mesh.vertices, axis=1) - 1)
            far = np.abs(np.linalg.norm(mesh.vertices - [apart, 0, 0], axis=1) - 1)
            assert np.minimum(near, far).max() <= mesh.error.bound
            rim = [[apart / 2, 0, math.sqrt(1 - apart**2 / 4)]]
            assert np.linalg.norm(mesh.vertices - rim, axis=1).min() <= 0.1
            assert mesh.nearest(rim)[1][0] <= mesh.error.bound
    touch = (ball | genus.sphere(1).translate([1.9999, 0, 0])).mesh(0.01)
    assert "small angle near [" in touch.error.doubt
    assert "not proven" in str(touch.report())


def test_sizes_far_from_one_change_no_normal():
    rng = np.random.default_rng(16)
    points, corners = net(rng, 3, 2), rng.standard_normal((10, 3))
    u, v = rng.uniform(0, 0.5, (2, 20))
    for make, given in [(genus.TensorPatch, points), (genus.TrianglePatch, corners)]:
        usual = make(given).normals(u, v)
        for size in (1e150, 1e120, 1e-120, 1e-200, 1e-290):
            np.testing.assert_allclose(make(given * size).normals(u, v), usual, atol=1e-9)
    lattice = genus.Lattice([0, 0, 0], np.eye(3), degree=2)
    assert lattice.degree == (2, 2, 2)
    with pytest.raises(TypeError, match="whole number or three"):
        genus.Lattice([0, 0, 0], np.eye(3), degree=(1, 2))
    # A profile that runs downward puts the fronts inside; a solid has them outside all the same.
    down = genus.elliptic_arc([0, 0, 0], [0, 0, -1], [1, 0, 0], 0, 180)
    ball = genus.solid(genus.PatchModel([genus.surface_of_revolution(down)])).mesh(0.01)
    assert ball.volume == pytest.approx(4 / 3 * math.pi, abs=0.01 * ball.area)


def test_a_torn_solid_is_refused():
    lattice = genus.Lattice([0, 0, 0], np.eye(3))
    lattice.points[3] += [0.5, 0, 0]
    with pytest.raises(genus.InvalidInput, match="torn"):
        genus.cube(2).deform(lattice).mesh(0.01)


def bent_bar(degrees: float, radius: float = 2.0, n: int = 12) -> genus.Lattice:
    """A bar of 6 x 1 x 1 bent round an axis at a distance from its middle."""
    lattice = genus.Lattice([0, -0.5, -0.5], np.diag([6.0, 1, 1]), degree=(n, 1, 1))
    x, y, z = np.moveaxis(lattice.points.copy(), -1, 0)
    angle = np.radians(degrees) * x / 6
    lattice.points = np.stack(
        [(radius - y) * np.sin(angle), radius - (radius - y) * np.cos(angle), z], -1
    )
    return lattice


def test_a_strong_bend_is_shown_to_be_one_to_one():
    bar = genus.cube([6, 1, 1]).translate([0, -0.5, -0.5])
    bend = bent_bar(300)
    assert bend.one_to_one().kind == "yes"
    ring = (bar - genus.cylinder(h=2, r=0.3, center=True).translate([2, 0, 0])).deform(bend)
    mesh = ring.mesh(0.02)
    assert mesh.error.certified, mesh.error.doubt
    assert mesh.topology.genus == 1

    over = bent_bar(420, n=20)
    report = over.one_to_one()
    assert report.kind == "no"
    p, q = report.points
    assert np.linalg.norm(p - q) > 1
    np.testing.assert_allclose(over.apply(p), over.apply(q), atol=1e-12)
    assert over.one_to_one([[0, -1, -1], [4, 1, 1]]).kind == "yes"
    assert over.one_to_one(genus.cube([4, 0.2, 0.2])).kind == "yes"
    assert bend.one_to_one(max_pairs=10).kind == "undecided"


# ---- Inverse FFD


def weights_of(degree, s: np.ndarray) -> np.ndarray:
    basis = [bernstein(n, s[:, k]) for k, n in enumerate(degree)]
    return np.einsum("ip,jp,kp->pijk", *basis).reshape(len(s), -1)


CASES = [
    # constraints, degree, distinct points
    (5, (3, 3, 3), 5),  # under-determined
    (300, (3, 3, 3), 300),  # over-determined
    (40, (2, 2, 2), 12),  # rank-deficient and over-determined
    (30, (4, 4, 4), 10),  # coincident, under-determined
    (60, (20, 2, 2), 60),
    (30, (1, 20, 1), 30),
]


@pytest.mark.parametrize(("n", "degree", "distinct"), CASES)
def test_inverse_ffd_agrees_with_gelsd(n, degree, distinct):
    linalg = pytest.importorskip("scipy.linalg", reason="scipy's gelsd is the second opinion")
    rng = np.random.default_rng(21)
    s = rng.uniform(0, 1, (distinct, 3))[np.arange(n) % distinct]
    targets = s + 0.1 * rng.standard_normal((n, 3))
    contradictory = distinct < n
    matrix = weights_of(degree, s)
    cut = 1e-10
    moves, _, rank, singular = linalg.lstsq(matrix, targets - s, cond=cut, lapack_driver="gelsd")
    lattice = genus.Lattice([0, 0, 0], np.eye(3), degree=degree)
    rest = lattice.points.copy()
    fit = lattice.fit(s, targets, rank_tolerance=cut)
    assert fit.rank == rank
    ours = (lattice.points - rest).reshape(-1, 3)
    condition = singular[0] / singular[rank - 1]
    scale = np.linalg.norm(moves)
    np.testing.assert_allclose(ours, moves, atol=1e-13 * condition * scale)
    residual = np.linalg.norm(matrix @ moves - (targets - s), axis=1)
    np.testing.assert_allclose(fit.residuals, residual, atol=1e-14 * condition * scale + 1e-12)
    if contradictory:
        assert fit.contradictions
        assert fit.unmet
        i, j = fit.contradictions[0]
        assert np.array_equal(s[i], s[j])
        assert "contradict" in str(fit)
    elif rank == n:
        assert fit.residual < 1e-10
        assert not fit.unmet


def test_a_moved_target_costs_one_back_substitution():
    rng = np.random.default_rng(22)
    s = rng.uniform(0, 1, (20, 3))
    lattice = genus.Lattice([0, 0, 0], np.eye(3), degree=(4, 4, 4))
    solver = lattice.solver(s, s)
    targets = s.copy()
    for _ in range(3):
        targets[7] += [0.01, 0, 0.02]
        fit = solver.solve(targets)
        assert fit.residual < 1e-10
        np.testing.assert_allclose(fit.lattice.apply(s), targets, atol=1e-10)
    assert np.array_equal(lattice.apply(s), s)


def test_derivatives_and_borders_can_be_asked_for():
    lattice = genus.Lattice([0, 0, 0], np.eye(3), degree=(6, 6, 6))
    p = [[0.5, 0.5, 0.5]] * 2
    fit = lattice.fit(
        p, [[0.5, 0.5, 0.55], [1.2, 0, 0.1]], directions=[[0, 0, 0], [1, 0, 0]], keep_border=1
    )
    assert fit.residual < 1e-10
    assert lattice.border_continuity >= 1
    np.testing.assert_allclose(lattice.jacobian([0.5, 0.5, 0.5])[:, 0], [1.2, 0, 0.1], atol=1e-9)
    edge = np.array([[0, 0.3, 0.6], [0.4, 1, 0.2]])
    assert np.array_equal(lattice.apply(edge), edge)


# ---- Subdivision


def test_subdivision_keeps_the_euler_number_and_its_limit():
    points = [[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    limits = []
    for levels in (1, 3, 5):
        mesh = genus.subdivide((points, faces), levels, limit=True)
        assert mesh.is_closed
        assert mesh.topology.euler == 2
        limits.append(mesh.vertices[0])
    # The first corner of the limit surface stays where it is.
    np.testing.assert_allclose(limits[1], limits[0], atol=1e-12)
    np.testing.assert_allclose(limits[2], limits[0], atol=1e-12)
    sharp = genus.subdivide(
        (points, faces),
        3,
        creases=[(a, b) for f in faces for a, b in zip(f, f[1:] + f[:1], strict=False)],
    )
    assert sharp.volume == pytest.approx(8)
    loop = genus.subdivide(genus.cube(1).mesh(), 2, "loop")
    assert loop.topology.euler == 2
    assert loop.is_closed


def opensubdiv_limit(peer, points, faces, scheme, creases):
    # Where a crease ends, their limit is that of a smooth vertex on the last level: it takes eight.
    lines = [f"{scheme} 8 {len(points)} {len(faces)} {len(creases)}"]
    lines += [" ".join(map(repr, map(float, p))) for p in points]
    lines += [" ".join(map(str, [len(f), *f])) for f in faces]
    lines += [f"{a} {b} {s}" for a, b, s in creases]
    done = subprocess.run(
        [peer, "limit"], input="\n".join(lines), text=True, capture_output=True, check=True
    )
    return np.array([line.split() for line in done.stdout.splitlines()], float)


@pytest.mark.parametrize("scheme", ["catmull_clark", "loop"])
def test_limit_points_are_those_of_opensubdiv(scheme, root, tmp_path):
    """A cube, open and closed, with and without creases, and a torus of uneven faces."""
    if not Path("/usr/include/opensubdiv").exists() or not shutil.which("c++"):
        pytest.skip("OpenSubdiv's headers (libosd-dev) or a compiler are not installed")
    peer = tmp_path / "peer"
    source = root / "tests" / "bench" / "opensubdiv_peer.cpp"
    subprocess.run(["c++", "-O1", "-std=c++17", source, "-losdCPU", "-o", peer], check=True)
    rng = np.random.default_rng(41)
    points = np.array(list(itertools.product((-1, 1), repeat=3))) + 0.2 * rng.standard_normal(
        (8, 3)
    )
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    if scheme == "loop":
        quads = [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]
    name = "catmark" if scheme == "catmull_clark" else "loop"
    edge = (quads[0][0], quads[0][1])
    for faces, creases in [
        (quads, []),
        (quads, [(*edge, 10.0)]),
        (quads, [(a, b, 10.0) for a, b in itertools.pairwise([*quads[0], quads[0][0]])]),
        (quads[1:], []),
    ]:
        theirs = opensubdiv_limit(peer, points, faces, name, creases)
        ours = genus.subdivide(
            (points, faces), 1, scheme, creases=[(a, b) for a, b, _ in creases], limit=True
        )
        np.testing.assert_allclose(ours.vertices[:8], theirs[:, :3], atol=2e-4)


# ---- Text models


def build(text: str, tolerance: float | None = 0.02) -> genus.Mesh:
    return genus.read_scad(text, tolerance=tolerance).mesh(tolerance)


def test_curves_in_text_models():
    # Below the parabola with apex (1, 2): two thirds of the control triangle.
    area = 4 / 3
    exact = build("linear_extrude(3) bezier_curve([[0,0],[1,2],[2,0]]);", 1e-4)
    assert exact.is_closed
    assert exact.volume == pytest.approx(3 * area, abs=3e-4)
    coarse = build("linear_extrude(3) bezier_curve([[0,0],[1,2],[2,0]], $fn=8);", None)
    assert coarse.volume == pytest.approx(3 * area * (1 - 1 / 64), rel=1e-12)
    ring = build("linear_extrude(1) bspline([[-1,-1],[1,-1],[1,1],[-1,1]]);", 1e-4)
    assert ring.topology.genus == 0
    # The ring's spline runs inside its square, and through (d_0 + 4 d_1 + d_2) / 6.
    assert ring.bounds[1, 0] < 1
    assert ring.bounds[1, 0] > 2 / 3 - 1e-9
    with pytest.raises(genus.ModelError, match=r"bspline\(\): degree"):
        build("linear_extrude(1) bspline([[0,0],[1,0]], closed=false);")
    with pytest.raises(genus.ModelError, match=r"points\[1\] is no vector"):
        build('linear_extrude(1) bezier_curve([[0,0],["a",0]]);')


def test_patches_in_text_models(models):
    # Six faces of a cube, one bulged: fronts are turned outside whatever the order of points.
    faces = """
    module face(h) bezier_patch([[[-1,-1,1],[-1,0,1],[-1,1,1]],
                                 [[0,-1,1],[0,0,1+h],[0,1,1]],
                                 [[1,-1,1],[1,0,1],[1,1,1]]]);
    patches() {
        face(1);
        mirror([0,0,1]) face(0);
        for (a = [0:3]) rotate([0, 0, 90 * a]) rotate([90, 0, 0]) face(0);
    }
    """
    mesh = build(faces, 0.001)
    # The bulge has the mean height of its Bernstein coefficients.
    assert mesh.validate() == []
    assert mesh.volume == pytest.approx(8 + 4 / 9, abs=0.01)
    with pytest.raises(genus.ModelError, match="open at edge"):
        build(faces.replace("face(1);\n", ""), 0.01)
    with pytest.raises(genus.ModelError, match="'cube' among patches"):
        build("patches() { cube(1); }")
    tetrahedron = """
    p = [[0,0,0],[1,0,0],[0,1,0],[0,0,1]];
    patches() for (f = [[0,1,2],[0,1,3],[0,2,3],[1,2,3]])
        triangle_patch([for (k = f) p[k]]);
    """
    assert build(tetrahedron).volume == pytest.approx(1 / 6)
    with pytest.raises(genus.ModelError, match=r"needs the name of a file|not found"):
        build('patches("missing.bpt");')


def test_deformations_in_text_models():
    bump = "move_points(from=[[5,5,10]], to=[[5,5,13]], degree=4) cube(10);"
    mesh = build(bump, 0.05)
    assert mesh.validate() == []
    assert mesh.error.bound <= 0.05
    top = mesh.vertices[np.argmin(np.linalg.norm(mesh.vertices - [5, 5, 13], axis=1))]
    assert np.linalg.norm(top - [5, 5, 13]) < 1.0
    run = genus.run_scad(
        "move_points(from=[[1,1,1],[1,1,1]], to=[[1,1,2],[1,2,1]]) cube(3);", tolerance=0.1
    )
    assert any("contradict" in m for m in run.messages)
    shear = "ffd(degree=1, moves=[for (i=[0:1], j=[0:1]) [[i,j,1],[2,0,0]]]) cube(4);"
    assert build(shear, 0.01).volume == pytest.approx(64, abs=0.1)
    with pytest.raises(genus.ModelError, match="names no control point"):
        build("ffd(degree=1, moves=[[[2,0,0],[1,0,0]]]) cube(4);")
    smooth = build("subdivide(3) cube(2, center=true);", None)
    assert len(smooth) == 6 * 4**3 * 2
    assert smooth.topology.euler == 2
    with pytest.raises(genus.ModelError, match="scheme"):
        build('subdivide(1, scheme="midpoint") cube(2);')


def test_the_bitten_teapot_with_its_bail(models):
    """One text model; GENUS_LONG=1 within 0.001."""
    tolerance = 0.001 if LONG else 0.02
    mesh = genus.read_scad(models / "teapot.scad", tolerance=tolerance).mesh(tolerance)
    topology = mesh.topology
    # Handle and bail are a handle each; the bite adds none.
    assert (topology.components, topology.genus, topology.closed) == (1, 2, True)
    assert mesh.error.bound <= tolerance
    assert mesh.validate() == []
    print(f"{len(mesh)} triangles, bound {mesh.error.bound}, seconds {dict(mesh.seconds)}")


def test_examples_of_the_page_run(root):
    text = (root / "docs" / "freeform.md").read_text()
    for block in text.split("```openscad\n")[1:]:
        mesh = build(block.split("```")[0], 0.05)
        assert mesh.is_closed
        assert mesh.topology.components == 2
    for block in text.split("```python\n")[1:]:
        exec(compile(block.split("```")[0], "freeform.md", "exec"), {})
