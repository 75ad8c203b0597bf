"""Meshes from Python: views, checks of arguments, what is known of a mesh."""

import copy
import gc
import pickle

import genus
import numpy as np
import pytest

CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
FACES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]


@pytest.fixture
def tetrahedron():
    return genus.Mesh(CORNERS, FACES)


def test_views_have_shape_and_type_and_cannot_be_written(tetrahedron):
    v, f = tetrahedron.vertices, tetrahedron.faces
    assert (v.shape, v.dtype, f.shape, f.dtype) == ((4, 3), np.float64, (4, 3), np.int32)
    np.testing.assert_array_equal(v, CORNERS)
    np.testing.assert_array_equal(f, FACES)
    for view in (v, f):
        with pytest.raises(ValueError, match="read-only"):
            view[0, 0] = 7
        with pytest.raises(ValueError, match="WRITEABLE"):
            view.flags.writeable = True


def test_views_share_memory_and_keep_the_mesh_alive(tetrahedron):
    view = tetrahedron.vertices
    assert np.shares_memory(view, tetrahedron.vertices)
    del tetrahedron
    gc.collect()
    np.testing.assert_array_equal(view, CORNERS)


def test_arrays_of_any_layout_are_taken():
    wanted = genus.Mesh(CORNERS, FACES)
    vertices = np.asfortranarray(np.array(CORNERS, dtype=np.float32))
    faces = np.array(FACES, dtype=np.uint16)[::-1][::-1]
    mesh = genus.Mesh(vertices, faces)
    np.testing.assert_array_equal(mesh.vertices, wanted.vertices)
    np.testing.assert_array_equal(mesh.faces, wanted.faces)


@pytest.mark.parametrize(
    ("vertices", "faces", "text"),
    [
        (np.zeros((4, 2)), FACES, r"vertices: .*\(n, 3\).*\(4, 2\)"),
        (np.zeros(3), FACES, r"vertices: .*\(n, 3\).*\(3,\)"),
        (CORNERS, np.zeros((2, 4), int), r"faces: .*\(m, 3\).*\(2, 4\)"),
        (CORNERS, [[0, 1, 4]], "faces: vertex 4 is not among the 4 vertices"),
        (CORNERS, [[0, 1, -1]], "faces: vertex -1 "),
        (CORNERS, [[0.0, 1.0, 2.0]], "faces: .*integers.*float64"),
        ("abc", FACES, r"vertices: expected numbers of shape \(n, 3\)"),
    ],
)
def test_wrong_shapes_are_named(vertices, faces, text):
    with pytest.raises(ValueError, match=text):
        genus.Mesh(vertices, faces)


def test_measures_of_a_tetrahedron(tetrahedron):
    assert tetrahedron.volume == pytest.approx(1 / 6, rel=1e-15)
    assert tetrahedron.area == pytest.approx(1.5 + np.sqrt(3) / 2, rel=1e-15)
    np.testing.assert_allclose(tetrahedron.centroid, [0.25] * 3, rtol=1e-15)
    # Integral of y^2 over the corner tetrahedron is 1/60, of xy 1/120; moved to the centroid.
    diagonal, off = 2 * (1 / 60 - 1 / 6 / 16), -(1 / 120 - 1 / 6 / 16)
    expected = np.full((3, 3), off) + (diagonal - off) * np.eye(3)
    np.testing.assert_allclose(tetrahedron.inertia, expected, rtol=1e-13)
    np.testing.assert_array_equal(tetrahedron.bounds, [[0, 0, 0], [1, 1, 1]])


def test_topology_of_a_tetrahedron(tetrahedron):
    t = tetrahedron.topology
    assert (t.vertices, t.edges, t.faces, t.euler, t.genus) == (4, 6, 4, 2, 0)
    assert (t.components, t.boundary_loops, t.mean_valence) == (1, 0, 3.0)
    assert t.closed
    assert t.oriented
    assert t.manifold
    assert t.complex_edges == []
    assert tetrahedron.is_closed
    assert tetrahedron.validate() == []


def test_defects_are_named_with_their_elements():
    doubled = genus.Mesh(CORNERS, [*FACES, [0, 1, 2]])
    kinds = {finding.defect for finding in doubled.validate()}
    assert "complex edge" in kinds
    assert not doubled.topology.manifold
    assert {tuple(sorted(e[:2])) for e in doubled.topology.complex_edges} == {
        (0, 1),
        (1, 2),
        (0, 2),
    }


def test_a_given_mesh_has_no_error_report(tetrahedron):
    assert tetrahedron.error is None
    assert tetrahedron.seconds == {}
    assert tetrahedron.explain() is None
    assert "error" not in tetrahedron.report()
    assert "4 - 6 + 4 = 2" in str(tetrahedron.report())


def test_an_empty_mesh_is_an_answer():
    empty = genus.Mesh([], [])
    assert empty.volume == 0
    assert len(empty) == 0
    assert empty.is_closed
    assert "empty" in str(empty.report())


def test_mesh_becomes_a_solid_and_back(tetrahedron):
    solid = genus.solid(tetrahedron)
    assert solid.contains([[0.1, 0.1, 0.1], [1, 1, 1]]).tolist() == [True, False]
    assert solid.bounds().tolist() == [[0, 0, 0], [1, 1, 1]]


def test_operators_on_meshes_are_exact():
    def box(low, high):
        x = np.array([low, high], float)
        corners = [[x[i & 1, 0], x[i >> 1 & 1, 1], x[i >> 2, 2]] for i in range(8)]
        quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        return genus.Mesh(corners, [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])])

    a, b = box([0, 0, 0], [2, 2, 2]), box([1, 1, 1], [3, 3, 3])
    assert [(a + b).volume, (a | b).volume, (a - b).volume, (a & b).volume] == [15, 15, 7, 1]
    bored = a - box([0.5, 0.5, -1], [1.5, 1.5, 3])
    assert bored.topology.genus == 1
    assert bored.validate() == []
    assert len(a - a) == 0
    with pytest.raises(genus.InvalidInput):
        a + genus.Mesh(CORNERS[:3], [[0, 1, 2]])


def test_meshes_are_copied_and_pickled():
    ball = genus.sphere(1).mesh(0.1)
    assert copy.copy(ball) is ball
    assert copy.deepcopy([ball])[0] is ball
    again = pickle.loads(pickle.dumps(ball))
    np.testing.assert_array_equal(again.vertices, ball.vertices)
    np.testing.assert_array_equal(again.faces, ball.faces)
    assert again.error is None


def test_hulls_of_meshes_and_points():
    box = genus.cube([1, 2, 3]).mesh()
    inner = genus.cube(0.5).translate([0.1, 0.1, 0.1]).mesh()
    assert genus.hull(box, inner).volume == 6
    assert genus.hull([box, inner]).volume == 6
    for points in (box.vertices, box.vertices.tolist(), np.asfortranarray(box.vertices)):
        whole = genus.hull(points)
        assert isinstance(whole, genus.Mesh)
        assert (whole.volume, whole.is_closed, len(whole)) == (6, True, 12)
    assert len(genus.hull(box.vertices[:3])) == 0
    for bad in (np.zeros((4, 2)), np.full((4, 3), np.nan)):
        with pytest.raises(ValueError, match=r"points|finite"):
            genus.hull(bad)
    with pytest.raises(TypeError, match="one kind"):
        genus.hull(box, genus.cube(1))
