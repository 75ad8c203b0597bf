"""Grids, marching cubes and squares, formulas: from Python's side."""

import math

import genus
import numpy as np
import pytest

CUBE = [[-2, -2, -2], [2, 2, 2]]


def ball_samples(n: int, dtype: type = float) -> np.ndarray:
    axis = np.linspace(-1, 1, n)
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    return (np.sqrt(x**2 + y**2 + z**2) - 0.8).astype(dtype)


def ball(values: np.ndarray, **options: object) -> genus.Mesh:
    spacing = 2 / (values.shape[0] - 1)
    return genus.marching_cubes(values, origin=(-1, -1, -1), spacing=spacing, **options)


def test_array_axes_are_x_y_z():
    values = np.ones((5, 6, 7))
    values[3, 1, 2] = -1  # one sample inside
    mesh = genus.marching_cubes(values, origin=(10, 20, 30), spacing=(1, 2, 3))
    assert mesh.is_closed
    assert mesh.volume > 0
    np.testing.assert_allclose(mesh.bounds, [[12.5, 21, 34.5], [13.5, 23, 37.5]])


@pytest.mark.parametrize(
    "dtype", [np.float64, np.float32, np.float16, np.int64, np.int8, np.uint16]
)
def test_every_real_type(dtype):
    values = np.arange(60).reshape(3, 4, 5) % 7
    level = 2.5
    mesh = genus.marching_cubes(values.astype(dtype), level)
    assert mesh.is_closed
    np.testing.assert_array_equal(
        mesh.vertices, genus.marching_cubes(values.astype(float), level).vertices
    )


def test_layout_in_memory_does_not_matter():
    values = ball_samples(24)
    reference = ball(values)
    padded = np.ones((48, 24, 30))
    padded[::2, :, 3:27] = values
    readonly = values.copy()
    readonly.flags.writeable = False
    for other in (np.asfortranarray(values), padded[::2, :, 3:27], values[::-1][::-1], readonly):
        mesh = ball(other)
        assert mesh.topology.euler == 2
        assert mesh.volume == pytest.approx(reference.volume, rel=1e-12)


def test_a_grid_gives_what_its_array_gives():
    values = ball_samples(20)
    grid = genus.Grid(values, (-1, -1, -1), 2 / 19)
    np.testing.assert_array_equal(grid.values, values)
    assert grid.shape == (20, 20, 20)
    with pytest.raises(ValueError, match="read-only"):
        grid.values[0, 0, 0] = 1
    assert genus.marching_cubes(grid).volume == pytest.approx(ball(values).volume, rel=1e-12)
    points = np.random.default_rng(1).uniform(-0.9, 0.9, (100, 3))
    distance = np.linalg.norm(points, axis=1)
    assert np.abs(grid.value(points) - (distance - 0.8)).max() < 0.05
    away = distance > 0.3
    normals = (
        grid.gradient(points)[away] / np.linalg.norm(grid.gradient(points)[away], axis=1)[:, None]
    )
    assert (normals * points[away] / distance[away, None]).sum(axis=1).min() > 0.98


def test_borders_are_capped_or_left_open():
    values = np.fromfunction(lambda i, j, k: k - 2.5, (4, 4, 6))
    assert genus.marching_cubes(values).is_closed
    mesh = genus.marching_cubes(values, close_border=False)
    assert not mesh.is_closed
    assert mesh.area == pytest.approx(9)


def test_values_that_are_not_finite_leave_no_hole():
    rng = np.random.default_rng(3)
    values = rng.choice([-1.0, 1.0, 0.0, np.nan, np.inf, -np.inf], (7, 7, 7))
    mesh = genus.marching_cubes(values)
    assert mesh.is_closed
    assert mesh.topology.manifold
    with pytest.raises(genus.InvalidInput):
        genus.Grid(values)


def test_integer_grids_are_watertight():
    for seed in range(100):
        rng = np.random.default_rng(seed)
        topology = genus.marching_cubes(rng.integers(-2, 3, (5, 5, 5))).topology
        assert (topology.closed, topology.manifold, topology.oriented) == (True,) * 3, seed


@pytest.mark.parametrize(
    ("values", "error"),
    [
        (np.zeros((3, 3)), ValueError),
        (np.zeros((3, 3, 1)), ValueError),
        (np.zeros((0, 3, 3)), ValueError),
        (np.zeros((2, 2, 2), complex), TypeError),
        ("text", (TypeError, ValueError)),
        (None, (TypeError, ValueError)),
        ([[[0, 1], [2]]], (TypeError, ValueError)),
    ],
)
def test_what_is_no_grid_is_refused(values, error):
    with pytest.raises(error):
        genus.marching_cubes(values)
    with pytest.raises(error):
        genus.Grid(values)


def test_bad_numbers_are_refused():
    values = ball_samples(4)
    for options in (
        {"level": math.nan},
        {"spacing": 0},
        {"spacing": -1},
        {"origin": (0, 0, math.inf)},
    ):
        with pytest.raises(genus.InvalidInput):
            genus.marching_cubes(values, **options)
    with pytest.raises(genus.InvalidInput):
        genus.marching_cubes(genus.sphere(1), cell_size=0)
    with pytest.raises(genus.UnboundedSolid):
        genus.marching_cubes(genus.half_space([0, 0, 1], 0))


def test_solids_by_cells():
    part = genus.cube(2, center=True) - genus.cylinder(h=3, r=0.6, center=True)
    plain = genus.marching_cubes(part, cell_size=0.1)
    sharp = genus.extended_marching_cubes(part, cell_size=0.1)
    exact = 8 - 2 * math.pi * 0.36
    for mesh in (plain, sharp):
        assert mesh.is_closed
        assert mesh.topology.genus == 1
    assert abs(sharp.volume - exact) < 0.2 * abs(plain.volume - exact)
    assert np.abs(np.abs(sharp.vertices).max(axis=0) - 1).max() < 1e-14
    assert genus.marching_cubes(genus.Solid()).topology.faces == 0


def test_squares_have_smaller_values_on_their_left():
    x, y = np.mgrid[-2:2:81j, -2:2:81j]
    [ring] = genus.marching_squares(np.hypot(x, y), 1, origin=(-2, -2), spacing=0.05)
    np.testing.assert_array_equal(ring[0], ring[-1])
    area = 0.5 * (ring[:-1, 0] * ring[1:, 1] - ring[1:, 0] * ring[:-1, 1]).sum()
    assert area == pytest.approx(math.pi, abs=0.01)
    [line] = genus.marching_squares(x, 0.31, origin=(-2, -2), spacing=(0.05, 0.05))
    np.testing.assert_allclose(line[:, 0], 0.31)
    assert len(genus.marching_squares(x, 0.31, close_border=True)) == 1
    assert genus.marching_squares(np.zeros((3, 3))) == []
    with pytest.raises(ValueError, match="2 dimensions"):
        genus.marching_squares(np.zeros((3, 3, 3)))
    with pytest.raises(ValueError, match="origin"):
        genus.marching_squares(np.zeros((3, 3)), origin=(0, 0, 0))


def test_formulas_by_text_operators_and_functions_are_one():
    x, y, z = genus.x, genus.y, genus.z
    by_text = genus.implicit("x^2 + y^2 + sin(z) - 1", CUBE)
    assert by_text == genus.implicit(x**2 + y**2 + genus.sin(z) - 1, CUBE)
    assert by_text == genus.implicit(lambda x, y, z: x * x + y * y + np.sin(z) - 1, CUBE)
    assert by_text == genus.implicit("x*x + y*y + sin(z) <= 1", CUBE)
    assert by_text.kind == "implicit"
    points = np.random.default_rng(2).uniform(-2, 2, (1000, 3))
    inside = points[:, 0] ** 2 + points[:, 1] ** 2 + np.sin(points[:, 2]) <= 1
    np.testing.assert_array_equal(by_text.contains(points), inside)


def test_functions_of_numpy_make_formulas():
    x, y, z = genus.x, genus.y, genus.z
    f = (
        np.maximum(np.abs(x), np.float32(0.5) * y)
        + np.hypot(y, z) / np.float64(2)
        - np.arctan2(z, x)
    )
    p = np.random.default_rng(4).uniform(-2, 2, (200, 3))
    a, b, c = p.T
    expected = np.maximum(np.abs(a), 0.5 * b) + np.hypot(b, c) / 2 - np.arctan2(c, a)
    np.testing.assert_allclose(f.value(p), expected, rtol=1e-13)
    gradient = (x**2 * y).gradient(p)
    np.testing.assert_allclose(gradient, np.stack([2 * a * b, a * a, 0 * a], axis=1), rtol=1e-13)
    with pytest.raises(TypeError):
        np.array([1, 2]) * x
    with pytest.raises(TypeError):
        np.gcd(x, y)
    with pytest.raises(TypeError):
        max(x, y)
    with pytest.raises(TypeError):
        bool(x)
    for wrong in ("1", None, [1], 1j):
        with pytest.raises(TypeError):
            x + wrong
        with pytest.raises(TypeError):
            genus.sin(wrong)


def test_mistakes_in_formulas_are_named():
    with pytest.raises(genus.InvalidInput, match="column 5"):
        genus.implicit("x + q", CUBE)
    for bounds in ([[0, 0, 0], [1, 1, -1]], [[0, 0, 0], [math.inf, 1, 1]], [0, 1], None):
        with pytest.raises((ValueError, TypeError)):
            genus.implicit("x", bounds)
    for f in (None, [genus.x], lambda x, y, z: "x", lambda x, y: x):
        with pytest.raises(TypeError):
            genus.implicit(f, CUBE)
    assert genus.implicit("1", CUBE).is_empty


def test_an_implicit_solid_meets_other_leaves():
    egg = genus.implicit("x^2 + y^2 + z^2 - 1", CUBE).scale([1, 1, 2]).translate([1, 0, 0])
    part = egg - genus.cylinder(h=9, r=0.4, center=True).translate([1, 0, 0])
    mesh = part.mesh(tolerance=0.05)
    assert mesh.is_closed
    assert mesh.topology.genus == 1
    assert mesh.error.certified
    assert mesh.error.measured <= mesh.error.bound <= 0.05
    assert not part.contains([[1, 0, 0]])[0]
    hits = part.ray_cast([[-5, 0, 0]], [[1, 0, 0]])
    np.testing.assert_allclose(hits.t, [5, 5.6, 6.4, 7], rtol=1e-9)


def test_sharp_edges_within_a_formula_are_met():
    part = genus.implicit("max(abs(x), abs(y), abs(z)) - 1", CUBE)
    mesh = genus.extended_marching_cubes(part, cell_size=0.13)
    assert mesh.is_closed
    assert mesh.volume == pytest.approx(8, abs=1e-12)
