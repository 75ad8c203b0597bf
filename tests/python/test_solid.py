"""Solids from Python: constructors, operators, moves, values, meshes, errors."""

import math

import genus
import numpy as np
import pytest

RNG_SEED = 20240


def sample(box, n=2000):
    low, high = np.asarray(box, float)
    return np.random.default_rng(RNG_SEED).uniform(low - 0.5, high + 0.5, (n, 3))


def test_radius_and_diameter_say_the_same():
    assert genus.sphere(2) == genus.sphere(r=2) == genus.sphere(d=4)
    assert genus.cylinder(3, 1) == genus.cylinder(h=3, d=2) == genus.cylinder(h=3, r1=1, r2=1)
    assert genus.cylinder(3, r1=2, r2=1) == genus.cylinder(3, d1=4, d2=2)
    assert genus.cone(3, 1) == genus.cylinder(3, r1=1, r2=0)
    assert hash(genus.sphere(2)) == hash(genus.sphere(d=4))
    assert genus.sphere(2) != genus.sphere(3)


@pytest.mark.parametrize(
    "make",
    [
        lambda: genus.sphere(),
        lambda: genus.sphere(1, d=2),
        lambda: genus.sphere(-1),
        lambda: genus.sphere(math.nan),
        lambda: genus.sphere(math.inf),
        lambda: genus.cylinder(1),
        lambda: genus.cylinder(1, 1, r1=2),
        lambda: genus.cylinder(1, r1=2),
        lambda: genus.cylinder(0, 1),
        lambda: genus.cube([1, 2]),
        lambda: genus.cube([1, 0, 2]),
        lambda: genus.cube("box"),
        lambda: genus.torus(1, 2),
        lambda: genus.half_space([0, 0, 0], 1),
        lambda: genus.quadric([1, 2, 3]),
        lambda: genus.cube(1).scale(0),
        lambda: genus.cube(1).scale([1, 1, math.nan]),
        lambda: genus.cube(1).mirror([0, 0, 0]),
        lambda: genus.cube(1).rotate(30, axis=[0, 0, 0]),
        lambda: genus.cube(1).transform(np.zeros((4, 4))),
        lambda: genus.cube(1).transform(np.eye(3)),
        lambda: genus.cube(1).color([1, 0]),
        lambda: genus.sphere(1).mesh(tolerance=-1),
        lambda: genus.sphere(1).mesh(tolerance=0),
        lambda: genus.sphere(1).mesh(tolerance=math.nan),
        lambda: genus.sphere(1).mesh(method="magic"),
        lambda: genus.sphere(1).contains([0, 0, 0]),
        lambda: genus.sphere(1).value(np.zeros((2, 2))),
    ],
)
def test_bad_arguments_are_value_errors_in_one_line(make):
    with pytest.raises(ValueError, match=r".") as caught:
        make()
    assert "\n" not in str(caught.value)


def test_error_types():
    assert issubclass(genus.InvalidInput, (genus.Error, ValueError))
    assert issubclass(genus.InvalidInput, ValueError)
    assert issubclass(genus.FileError, OSError)
    for error in (genus.InvalidInput, genus.FileError, genus.ModelError, genus.UnboundedSolid,
                  genus.ToleranceNotMet):  # fmt: skip
        assert issubclass(error, genus.Error)


def test_operators_are_those_of_sets():
    a, b = genus.sphere(1.5), genus.cube(2)
    p = sample([[-1.5] * 3, [2] * 3])
    in_a, in_b = a.contains(p), b.contains(p)
    np.testing.assert_array_equal((a + b).contains(p), in_a | in_b)
    np.testing.assert_array_equal((a | b).contains(p), in_a | in_b)
    np.testing.assert_array_equal((a & b).contains(p), in_a & in_b)
    np.testing.assert_array_equal((a - b).contains(p), in_a & ~in_b)  # no sample on a border
    c = genus.torus(1, 0.4)
    in_c = c.contains(p)
    np.testing.assert_array_equal(genus.union([a, b, c]).contains(p), in_a | in_b | in_c)
    np.testing.assert_array_equal(genus.union(a, b, c).contains(p), in_a | in_b | in_c)
    np.testing.assert_array_equal(genus.intersection(a, b, c).contains(p), in_a & in_b & in_c)
    np.testing.assert_array_equal(genus.difference(a, b, c).contains(p), in_a & ~in_b & ~in_c)
    with pytest.raises(TypeError):
        a + 1


def test_moves_move_points():
    solid = genus.cube([1, 2, 3]) - genus.sphere(0.7)
    p = sample([[0, 0, 0], [1, 2, 3]])
    inside = solid.contains(p)
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    turn_z = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    maps = [
        (solid.translate([4, 5, 6]), p + [4, 5, 6]),
        (solid.scale(2), p * 2),
        (solid.scale([1, -2, 3]), p * [1, -2, 3]),
        (solid.mirror([1, 0, 0]), p * [-1, 1, 1]),
        (solid.rotate(30), p @ turn_z.T),
        (solid.rotate([0, 0, 30]), p @ turn_z.T),
        (solid.rotate(30, axis=[0, 0, 2]), p @ turn_z.T),
        (solid.rotate([90, 0, 90]), p[:, [2, 0, 1]]),
        (solid.transform(np.c_[turn_z, [1, 2, 3]]), p @ turn_z.T + [1, 2, 3]),
    ]
    for moved, q in maps:
        np.testing.assert_array_equal(moved.contains(q), inside)


def test_ten_numbers_and_the_matrix_are_one_quadric():
    ten = [1, 0.1, 0.2, 0.3, 2, 0.4, 0.5, 3, 0.6, -4]
    rows = [[1, 0.1, 0.2, 0.3], [0.1, 2, 0.4, 0.5], [0.2, 0.4, 3, 0.6], [0.3, 0.5, 0.6, -4]]
    p = sample([[-2] * 3, [2] * 3], 200)
    q = np.c_[p, np.ones(len(p))]
    expected = np.einsum("ni,ij,nj->n", q, rows, q)
    for coefficients in (ten, rows, np.array(rows)):
        value = genus.quadric(coefficients).value(p)
        factor = value[0] / expected[0]  # F counts up to a positive factor
        assert factor > 0
        np.testing.assert_allclose(value, factor * expected, rtol=1e-12)


def test_gradient_is_that_of_the_value():
    solid = genus.torus(2, 0.5) - genus.ellipsoid(1, 3, 1)
    p = sample([[-2.5, -2.5, -0.5], [2.5, 2.5, 0.5]], 300)
    h = 1e-6
    step = np.eye(3) * h
    numeric = np.stack([(solid.value(p + e) - solid.value(p - e)) / (2 * h) for e in step], axis=1)
    gradient = solid.gradient(p)
    error = np.abs(numeric - gradient).max(axis=1) / (1 + np.abs(gradient).max(axis=1))
    assert np.quantile(error, 0.98) < 1e-6  # the rest straddle a crease


def test_large_and_small_batches_agree():
    solid = genus.sphere(1) - genus.cylinder(h=3, r=0.3, center=True)
    p = sample([[-1] * 3, [1] * 3], 100_000)
    whole = solid.value(p)
    np.testing.assert_array_equal(whole[:5], solid.value(p[:5]))
    assert solid.value([]).shape == (0,)
    assert solid.gradient(np.zeros((0, 3))).shape == (0, 3)


def test_rays_enter_and_leave_in_order():
    solid = genus.sphere(2) - genus.sphere(1)
    hits = solid.ray_cast([[-5, 0, 0], [0, 0, 0], [0, 9, 0]], [[1, 0, 0], [0, 0, 2], [1, 0, 0]])
    assert hits.ray.tolist() == [0, 0, 0, 0, 1, 1]
    np.testing.assert_allclose(hits.t, [3, 4, 6, 7, 0.5, 1], rtol=1e-12)
    assert hits.entering.tolist() == [True, False, True, False, True, False]
    np.testing.assert_allclose(hits.normals[:2], [[-1, 0, 0], [1, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(hits.points[4:], [[0, 0, 1], [0, 0, 2]], atol=1e-12)
    with pytest.raises(ValueError, match=r"1 origins, 2 directions"):
        solid.ray_cast(np.zeros((1, 3)), np.ones((2, 3)))


def test_hits_tell_the_leaf():
    plate, hole = genus.cube([6, 6, 4], center=True), genus.cylinder(h=9, r=1, center=True)
    pin = genus.cylinder(h=2, r=1).translate([0, 0, -2])
    part = ((plate - hole) + pin).color([1, 0, 0])
    assert part.leaves() == ["cube([6, 6, 4])", "cylinder(h = 9, r = 1)", "cylinder(h = 2, r = 1)"]
    hits = part.ray_cast([[-9, 0, 1], [0.1, 0, 9]], [[1, 0, 0], [0, 0, -1]])
    assert hits.leaf.dtype == np.int64
    assert hits.leaf.tolist() == [0, 1, 1, 0, 2, 2]
    assert hits.leaf_names == [part.leaves()[i] for i in hits.leaf]
    none = part.ray_cast([[9, 9, 9]], [[1, 0, 0]])
    assert none.leaf.shape == (0,)
    assert none.leaf_names == []
    assert genus.Solid().leaves() == []


def test_the_empty_solid_and_nothing_left():
    assert genus.Solid().is_empty
    assert genus.union([]).is_empty
    nothing = genus.cube(1) - genus.cube(3, center=True)
    mesh = nothing.mesh(0.1)
    assert len(mesh) == 0
    assert mesh.is_closed


def test_mesh_reports_error_time_and_what_was_left_out():
    solid = genus.sphere(5) - genus.cylinder(h=20, r=2, center=True)
    mesh = solid.mesh(tolerance=0.05)
    assert 0 < mesh.error.measured <= mesh.error.bound <= 0.05
    assert mesh.topology.genus == 1
    assert mesh.validate() == []
    assert 0 < max(mesh.error.parts.values()) <= mesh.error.bound
    assert all(s >= 0 for s in mesh.seconds.values())
    report = mesh.report()
    assert report["seconds"]["total"] >= 0.9 * sum(mesh.seconds.values())
    for word in ("triangles", "V - E + F", "genus", "volume", "error bound", "error measured"):
        assert word in str(report)
    # Cap-and-bore volume in closed form: a sphere with a hole of half length sqrt(25 - 4).
    exact = 4 / 3 * math.pi * (25 - 4) ** 1.5
    assert abs(mesh.volume - exact) <= mesh.error.bound * mesh.area * 1.01


def test_without_measuring_nothing_is_measured():
    report = genus.sphere(1).mesh(0.1, measure=False).report()
    assert report["error"]["measured"] is None


def test_what_misses_is_left_out_and_said():
    solid = genus.sphere(1) - genus.sphere(1).translate([10, 0, 0])
    assert solid.explain().entries
    assert "1 leaves" in str(solid.explain())
    with_plan, without = solid.mesh(0.05), solid.mesh(0.05, plan=False)
    np.testing.assert_array_equal(with_plan.vertices, without.vertices)
    np.testing.assert_array_equal(with_plan.faces, without.faces)


def test_unbounded_solids_name_the_leaf():
    with pytest.raises(genus.UnboundedSolid, match="half"):
        (genus.sphere(1) + genus.half_space([0, 0, 1], 0)).mesh(0.1)


def test_a_tolerance_out_of_reach_is_an_error_with_numbers():
    with pytest.raises(genus.ToleranceNotMet) as caught:
        genus.sphere(1).mesh(tolerance=1e-9, max_triangles=1000)
    assert caught.value.asked == 1e-9
    assert caught.value.reached > 1e-9
    for box in caught.value.where:
        assert np.shape(box) == (2, 3)


def test_any_thread_count_gives_the_same_mesh():
    solid = genus.torus(3, 1) - genus.cube(4)
    meshes = []
    before = genus.thread_count()
    try:
        for threads in (1, 2, 5):
            genus.set_thread_count(threads)
            meshes.append(solid.mesh(0.05))
    finally:
        genus.set_thread_count(before)
    for mesh in meshes[1:]:
        np.testing.assert_array_equal(mesh.vertices, meshes[0].vertices)
        np.testing.assert_array_equal(mesh.faces, meshes[0].faces)
