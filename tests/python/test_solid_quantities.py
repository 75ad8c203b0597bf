"""Volume and area without a mesh, and meshes of a region, from Python."""

import math
import pickle

import genus
import numpy as np
import pytest

PIPE = genus.cylinder(h=4, r=1, center=True)

CLOSED_FORMS = {
    "ball": (genus.sphere(1), 4 * math.pi / 3, 4 * math.pi),
    "cylinder": (PIPE, 4 * math.pi, 10 * math.pi),
    "lens": (genus.sphere(1) & genus.sphere(1).translate([1, 0, 0]), 5 * math.pi / 12, 2 * math.pi),
}


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_closed_forms_lie_within_the_bounds(name):
    solid, volume, area = CLOSED_FORMS[name]
    for found, exact in [(solid.volume(relative=1e-9), volume), (solid.area(relative=1e-9), area)]:
        assert found.certified
        assert found.bound <= 1e-9 * exact
        assert abs(found - exact) <= found.bound + 2e-16 * exact


def test_a_quantity_is_a_float_that_knows_its_bound():
    v = genus.cylinder(h=1, r=1).volume(tolerance=1e-3)
    value, bound = v
    assert isinstance(v, float)
    assert (value, bound) == (v.value, v.bound)
    assert v.low <= math.pi <= v.high
    assert bound <= 1e-3
    assert np.asarray([v, 1.0]).dtype == np.float64
    again = pickle.loads(pickle.dumps(v))
    assert (again, again.bound, again.certified) == (v, v.bound, v.certified)


@pytest.mark.parametrize("bad", [0, -1, math.nan, math.inf])
def test_bad_tolerances_are_refused(bad):
    with pytest.raises(genus.InvalidInput, match="tolerance"):
        genus.sphere(1).volume(tolerance=bad)
    with pytest.raises(genus.InvalidInput, match="relative"):
        genus.sphere(1).area(relative=bad)


def test_unbounded_and_empty_solids():
    with pytest.raises(genus.UnboundedSolid):
        genus.half_space([0, 0, 1], 0).volume()
    assert genus.Solid().volume() == 0
    assert genus.Solid().area().bound == 0


def test_a_region_is_cut_out_and_closed():
    ball = genus.sphere(1)
    part = ball.mesh(0.01, region=[[0, 0, 0], [2, 2, 2]])
    assert part.is_closed
    assert part.volume == pytest.approx(math.pi / 6, abs=0.02)
    assert part.bounds.min() == 0.0
    for bad in ([[0, 0, 0], [0, 1, 1]], [[0, 0, 0], [math.inf, 1, 1]], [[1, 1, 1], [0, 0, 0]]):
        with pytest.raises(ValueError, match="region"):
            ball.mesh(0.01, region=bad)
    assert len(ball.mesh(0.01, region=[[5, 5, 5], [6, 6, 6]])) == 0


def test_nearest_points_of_faces_edges_and_corners():
    block = genus.cube(2, center=True)
    points, distances, bounds = block.nearest([[0.2, 0.3, 3], [0.2, 2, 3], [4, 2, 3], [0, 0, 0.9]])
    np.testing.assert_allclose(
        points, [[0.2, 0.3, 1], [0.2, 1, 1], [1, 1, 1], [0, 0, 1]], atol=1e-12
    )
    np.testing.assert_allclose(distances, [2, 5**0.5, 14**0.5, 0.1], rtol=1e-12)
    assert (bounds < 1e-8).all()
    assert block.nearest(np.zeros((0, 3)))[0].shape == (0, 3)
    with pytest.raises(genus.InvalidInput):
        genus.Solid().nearest([[0, 0, 0]])
