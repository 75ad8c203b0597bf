"""Storage forms, operators and polygons from Python: views without copies, what theory promises."""

import gc
import itertools
import re

import genus
import numpy as np
import pytest

SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4]]
HOLE = [[1, 1], [2, 1], [2, 2], [1, 2]]


@pytest.fixture
def sphere():
    return genus.icosphere(r=2, parts=5)


def test_halfedge_arrays_are_views_that_keep_their_mesh(sphere):
    mesh = sphere.halfedge()
    assert np.shares_memory(mesh.to, mesh.to)
    assert np.shares_memory(mesh.points, mesh.points)
    to, points = mesh.to, mesh.points
    with pytest.raises(ValueError, match="read-only"):
        to[0] = 1
    h = np.arange(len(to))
    np.testing.assert_array_equal(mesh.opposite[mesh.opposite], h)
    np.testing.assert_array_equal(mesh.next[mesh.next[mesh.next]], h)
    np.testing.assert_array_equal(to[mesh.opposite[mesh.next]], to)
    np.testing.assert_array_equal(np.sort(mesh.face.reshape(-1)), np.arange(mesh.n_faces).repeat(3))
    del mesh
    gc.collect()
    np.testing.assert_array_equal(points, sphere.vertices)


def test_views_show_the_mesh_as_it_was_before_an_operator(sphere):
    mesh = sphere.halfedge()
    before, copy = mesh.to, mesh.to.copy()
    walk = mesh.outgoing(3)
    first = next(walk)
    for face in range(100):
        mesh.split_face(face, mesh.points[mesh.face_vertices(face)].mean(axis=0))
    np.testing.assert_array_equal(before, copy)
    assert len(mesh.to) == len(before) + 600
    assert [first, *walk] == list(sphere.halfedge().outgoing(3))
    mesh.check()


def test_circulators_and_rings_agree(sphere):
    mesh, small = sphere.halfedge(), sphere.triangle_halfedge()
    starts, neighbours = mesh.one_rings()
    valences = np.diff(starts)
    assert sorted(set(valences.tolist())) == [5, 6]
    assert (valences == 5).sum() == 12
    for v in range(0, mesh.n_vertices, 7):
        ring = mesh.vertex_ring(v)
        assert ring == [mesh.to[h] for h in mesh.outgoing(v)]
        assert ring[::-1] == neighbours[starts[v] : starts[v + 1]].tolist()
        assert sorted(ring) == sorted(small.vertex_ring(v))
        assert mesh.valence(v) == len(mesh.face_ring(v)) == len(ring)
        assert all(v in sphere.faces[f] for f in mesh.face_ring(v))
        assert all(mesh.ends(h)[0] == v for h in mesh.outgoing(v))
    for f in range(0, mesh.n_faces, 11):
        assert mesh.face_vertices(f) == sphere.faces[f].tolist()
        assert all(mesh.face[h] == f for h in mesh.around(f))
        assert mesh.degree(f) == 3


def test_ring_sums_are_those_of_numpy(sphere):
    edges = np.unique(np.sort(sphere.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
    expected = np.zeros_like(sphere.vertices)
    for a, b in ((0, 1), (1, 0)):
        np.add.at(expected, edges[:, a], sphere.vertices[edges[:, b]])
    for form in (sphere.halfedge(), sphere.triangle_halfedge()):
        np.testing.assert_allclose(form.ring_sums(sphere.vertices), expected, atol=1e-12)
        ones = form.ring_sums(np.ones(len(sphere.vertices)))
        assert ones.shape == (len(sphere.vertices),)
        assert ones.sum() == 2 * len(edges)
        with pytest.raises(ValueError, match="one row"):
            form.ring_sums([1.0])


def test_operators_keep_the_euler_number(sphere):
    mesh = sphere.halfedge()
    random = np.random.default_rng(3)
    done = 0
    for _ in range(3000):
        h = int(random.choice(mesh.halfedges()[:: 1 + len(mesh.to) // 50]))
        kind = random.integers(4)
        if kind == 0:
            mesh.split_edge(h, mesh.points[list(mesh.ends(h))].mean(axis=0))
        elif kind == 1 and mesh.can_flip_edge(h):
            mesh.flip_edge(h)
        elif mesh.can_collapse_edge(h):
            mesh.collapse_edge(h)
        else:
            continue
        done += 1
        assert mesh.euler == 2
    assert done > 1000
    mesh.check()
    mesh.compact()
    mesh.check()
    assert len(mesh.halfedges()) == len(mesh.to)
    t = mesh.mesh().topology
    assert t.closed
    assert t.manifold
    assert t.genus == 0


def test_cut_and_join_undo_each_other():
    mesh = genus.platonic(4, 3).halfedge()
    a, _, c, _ = mesh.around(0)
    h = mesh.cut_face(a, c)
    assert mesh.n_faces == 7
    assert mesh.find(*mesh.ends(h)) == h
    mesh.join_faces(h)
    assert mesh.n_faces == 6
    assert mesh.polygons().topology.euler == 2


def test_what_is_not_there_is_named(sphere):
    mesh = sphere.halfedge()
    for call in (mesh.outgoing, mesh.around, mesh.loop, mesh.flip_edge, mesh.valence):
        for number in (-1, 10**6, 2**40):
            with pytest.raises(genus.InvalidInput, match=f"there is no .* {number}"):
                call(number)
    h = next(iter(mesh.outgoing(0)))
    mesh.collapse_edge(h)
    with pytest.raises(genus.InvalidInput, match="there is no"):
        mesh.collapse_edge(h)
    doubled = genus.Mesh(sphere.vertices, [*sphere.faces, sphere.faces[7]])
    for form in ("halfedge", "triangle_halfedge", "winged_edge"):
        with pytest.raises(genus.InvalidInput, match=r"edge|face"):
            getattr(doubled, form)()


def test_boundary_of_a_sheet():
    mesh = genus.grid(4, 3).halfedge()
    (first,) = mesh.boundary_loops()
    loop = list(mesh.loop(first))
    assert len(loop) == 14
    assert all(mesh.face[h] == -1 for h in loop)
    assert mesh.previous(loop[1]) == loop[0]


def test_the_other_forms_tell_the_same(sphere):
    winged = sphere.winged_edge()
    e = len(winged.edge_vertices)
    assert e == sphere.topology.edges
    assert (winged.edge_vertices[:, 0] != winged.edge_vertices[:, 1]).all()
    for side in (0, 1):
        follows = winged.edge_next[:, side]
        assert (winged.edge_faces[follows] == winged.edge_faces[:, [side]]).any(axis=1).all()
    assert len(winged.face_edges(5)) == 3
    assert len(winged.vertex_edges(0)) == 5
    np.testing.assert_array_equal(winged.polygons().corners, sphere.faces.ravel())

    faces = sphere.face_based()
    for f, i in itertools.product(range(0, len(sphere), 9), range(3)):
        other = faces.neighbours[f, i]
        side = {sphere.faces[f, i], sphere.faces[f, (i + 1) % 3]}
        assert side <= set(sphere.faces[other].tolist())
    assert sorted(faces.vertex_faces(0)) == sorted(sphere.halfedge().face_ring(0))

    strips = sphere.strips()
    assert len(strips) == len(strips.starts) - 1
    back = strips.mesh()
    assert len(back) == len(sphere)
    assert back.volume == pytest.approx(sphere.volume, rel=1e-14)
    assert sphere.triangle_list().shape == (len(sphere), 3, 3)
    np.testing.assert_array_equal(sphere.triangle_list(), sphere.vertices[sphere.faces])


def test_bytes_of_the_forms_are_those_of_the_table():
    """At 4-byte numbers: 64, 120, 120 bytes a vertex; strips 24 + 24 a strip."""
    mesh = genus.icosphere(parts=60)
    n = len(mesh.vertices)
    assert mesh.face_based().memory_bytes(4) / n == pytest.approx(64, rel=0.05)
    assert mesh.winged_edge().memory_bytes(4) / n == pytest.approx(120, rel=0.05)
    assert mesh.halfedge().memory_bytes(4) / n == pytest.approx(120, rel=0.05)
    assert mesh.triangle_halfedge().memory_bytes() / n <= 76.1
    strips = mesh.strips()
    per_vertex = 24 + 24 * len(strips) / n
    assert strips.memory_bytes(4) / n == pytest.approx(per_vertex, rel=0.05)


@pytest.mark.parametrize(("p", "q"), [(3, 3), (4, 3), (3, 4), (5, 3), (3, 5)])
def test_platonic_solids_and_their_duals(p, q):
    mesh, d = genus.platonic(p, q), 2 * p - p * q + 2 * q
    t = mesh.topology
    assert (t.vertices, t.edges, t.faces) == (4 * p // d, 2 * p * q // d, 4 * q // d)
    assert mesh.faces.shape == (t.faces, p)
    lengths = np.linalg.norm(mesh.vertices[mesh.faces] - mesh.vertices[np.roll(mesh.faces, 1, 1)],
                             axis=2)  # fmt: skip
    np.testing.assert_allclose(lengths, lengths[0, 0], rtol=1e-14)
    assert mesh.dual().topology.faces == t.vertices
    twice = mesh.dual().dual()
    rotated = [{tuple(np.roll(f, i)) for i in range(p)} for f in mesh.faces]
    for i, f in enumerate(twice.faces):
        assert tuple(f) in rotated[i]


def test_only_five_platonic_solids():
    for p, q in itertools.product(range(-1, 12), repeat=2):
        if p < 3 or q < 3 or (p - 2) * (q - 2) >= 4:
            with pytest.raises(genus.InvalidInput, match=r"\(p - 2\)\(q - 2\) < 4"):
                genus.platonic(p, q)


def test_a_polygon_mesh_keeps_its_faces():
    corners = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 3]]
    mesh = genus.PolygonMesh(corners, [[3, 2, 1, 0], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    assert [len(f) for f in mesh.faces] == [4, 3, 3, 3, 3]
    assert len(mesh) == 5
    assert mesh.starts.tolist() == [0, 4, 7, 10, 13, 16]
    assert mesh.volume == pytest.approx(4, rel=1e-15)
    assert mesh.bounds.tolist() == [[0, 0, 0], [2, 2, 3]]
    assert mesh.is_closed
    assert mesh.validate() == []
    assert len(mesh.triangles()) == 6
    assert len(genus.PolygonMesh([], [])) == 0
    with pytest.raises(ValueError, match="vertex 9"):
        genus.PolygonMesh(mesh.vertices, [[0, 1, 9]])


@pytest.mark.parametrize("method", ["auto", "ear", "sweep", "delaunay"])
def test_triangulate(method):
    points = np.array(SQUARE + HOLE, float)
    triangles = genus.triangulate(SQUARE, [HOLE], method)
    assert (triangles.shape, triangles.dtype) == ((8, 3), np.int32)
    a, b, c = points[triangles].transpose(1, 2, 0)
    areas = ((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]) / 2
    assert (areas > 0).all()
    assert areas.sum() == 15


def test_triangulate_refuses_with_the_place():
    with pytest.raises(genus.InvalidInput, match="meets the edge"):
        genus.triangulate([[0, 0], [4, 4], [4, 0], [0, 4]])
    with pytest.raises(genus.InvalidInput, match="auto, ear, sweep, delaunay"):
        genus.triangulate(SQUARE, method="magic")
    with pytest.raises(ValueError, match=r"polygon: expected an array of shape \(n, 2\)"):
        genus.triangulate([[0, 0, 0]])
    with pytest.raises(ValueError, match=r"holes\[0\]: expected"):
        genus.triangulate(SQUARE, [["a"]])


def test_make_and_kill():
    """A block with a bore: five kinds of operators, genus 1."""
    mesh = genus.LoopMesh()

    def loop_of(points, corner):
        """A dangling chain from the corner, closed to a face of its own at its left."""
        first = mesh.mev(corner, points[1])
        last = first
        for p in points[2:]:
            last = mesh.mev(last ^ 1, p)
        return first, last

    def lift(face, by):
        start = mesh.corner(mesh.loops(face)[0])
        sides = [start]
        while (h := mesh.next(sides[-1])) != start:
            sides.append(h)
        up = [mesh.mev(h, mesh.point(mesh.ends(h)[0]) + by) for h in sides]
        rim = mesh.mef(up[0] ^ 1, up[1] ^ 1)
        for i in range(1, len(up)):
            mesh.mef(up[i] ^ 1, up[i + 1] ^ 1 if i + 1 < len(up) else rim)

    a = mesh.mvfs([0, 0, 0])
    first, last = loop_of([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], ~a)
    top = mesh.face(mesh.mef(last ^ 1, first))
    lift(top, [0, 0, 1])
    assert mesh.counts() == {
        "vertices": 8, "edges": 12, "faces": 6, "loops": 6, "shells": 1, "genus": 0,
    }  # fmt: skip
    bridge = mesh.mev(mesh.corner(mesh.loops(top)[0]), [1, 1, 1])
    first, last = loop_of([None, [3, 1, 1], [3, 3, 1], [1, 3, 1]], bridge ^ 1)
    inner = mesh.face(mesh.mef(first, last ^ 1) ^ 1)
    mesh.kemr(bridge)
    lift(inner, [0, 0, -1])
    (bottom,) = [
        f for f in mesh.faces()
        if f != inner and all(mesh.point(v)[2] == 0 for v in face_vertices(mesh, f))
    ]  # fmt: skip
    mesh.kfmrh(bottom, inner)
    mesh.check()
    assert mesh.counts() == {
        "vertices": 16, "edges": 24, "faces": 10, "loops": 12, "shells": 1, "genus": 1,
    }  # fmt: skip
    block = mesh.polygons()
    assert block.volume == 12
    assert block.topology.genus == 1
    assert block.validate() == []
    with pytest.raises(genus.InvalidInput, match="kemr"):
        mesh.kemr(mesh.corner(mesh.loops(top)[0]))
    with pytest.raises(genus.InvalidInput, match="no halfedge 999"):
        mesh.kev(999)


def face_vertices(mesh, face):
    start = h = mesh.corner(mesh.loops(face)[0])
    while True:
        yield mesh.ends(h)[0]
        h = mesh.next(h)
        if h == start:
            return


def test_simplify_reports_a_bound_that_holds():
    ball = genus.icosphere(r=10, parts=24)
    for tolerance in (1.0, 0.25):
        rough = ball.simplify(tolerance)
        assert rough.error.certified
        assert rough.error.measured <= rough.error.bound <= tolerance
        assert ball.distance(rough).max <= rough.error.bound
        assert rough.topology.genus == 0
        assert rough.is_closed
        assert len(rough) < len(ball) / 10
        assert "simplify" in rough.seconds
    assert len(ball.simplify(faces=500)) == 500
    guessed = ball.simplify(0.25, certify=False)
    assert not guessed.error.certified
    with pytest.raises(genus.InvalidInput, match="tolerance or max_faces"):
        ball.simplify()


def test_repair_says_what_it_did(sphere):
    random = np.random.default_rng(5)
    soup = sphere.triangle_list().reshape(-1, 3)
    faces = np.arange(len(soup), dtype=np.int32).reshape(-1, 3)
    turned = random.random(len(faces)) < 0.3
    faces[turned] = faces[turned][:, ::-1]
    mesh, done = genus.Mesh(soup, faces[3:]).repair()
    assert done["welded_vertices"] == len(soup) - len(sphere.vertices)
    assert done["closed_holes"] >= 1
    assert mesh.validate() == []
    assert mesh.volume == pytest.approx(sphere.volume, rel=1e-2)
    fin = genus.Mesh([*sphere.vertices, [9, 9, 9]], [*sphere.faces, [0, 1, len(sphere.vertices)]])
    assert fin.repair(non_manifold="drop")[1]["dropped_faces"] == 1
    assert not fin.repair(non_manifold="keep", max_hole=0)[0].topology.manifold
    with pytest.raises(genus.InvalidInput, match="keep, split, drop"):
        sphere.repair(non_manifold="melt")
    assert len(genus.Mesh(soup, faces).weld().vertices) == len(sphere.vertices)


def test_where_points_and_rays_are(sphere):
    random = np.random.default_rng(7)
    points = random.uniform(-3, 3, (2000, 3))
    r = np.linalg.norm(points, axis=1)
    sure = np.abs(r - 2) > 0.05
    np.testing.assert_array_equal(sphere.contains(points)[sure], (r < 2)[sure])
    closest, distance, face = sphere.nearest(points)
    np.testing.assert_allclose(distance, np.linalg.norm(points - closest, axis=1), atol=1e-14)
    np.testing.assert_allclose(distance[sure], np.abs(r - 2)[sure], atol=0.05)
    corners = sphere.vertices[sphere.faces[face]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    assert np.abs(((closest - corners[:, 0]) * normal).sum(axis=1)).max() < 1e-14
    ray, t, face = sphere.ray_cast(points, -points)
    inside = sphere.contains(points)
    np.testing.assert_array_equal(np.bincount(ray, minlength=len(points)), 2 - inside)
    hits = points[ray] * (1 - t)[:, None]
    np.testing.assert_allclose(np.linalg.norm(hits, axis=1), 2, atol=0.05)
    assert face.max() < len(sphere)
    open_sheet = genus.grid(2, 2).triangles()
    with pytest.raises(genus.InvalidInput, match="not closed"):
        open_sheet.contains(points)


def test_the_examples_of_the_page_run(root, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (root / "docs" / "meshes.md").read_text()
    examples = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert len(examples) == 6
    names = {}
    for example in examples:
        exec(compile(example, "meshes.md", "exec"), names)
