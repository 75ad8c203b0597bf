"""Booleans, hulls, sums, extrusions and plane regions as Python users call them."""

import itertools
import math
import random

import genus
import numpy as np
import pytest


def box(low, high):
    size = np.subtract(high, low)
    return genus.cube(size).translate(low).mesh()


A, B, C = box([0, 0, 0], [4, 4, 4]), box([2, 2, 2], [6, 6, 6]), box([1, 1, -1], [3, 3, 5])


def volume_by_cells(inside):
    """Volume of a set of unit cells of [-1, 7]^3, one of which is inside or not as a whole."""
    middle = np.arange(-1, 7) + 0.5
    return sum(inside(*p) for p in itertools.product(middle, repeat=3))


def in_box(mesh, *p):
    low, high = mesh.bounds
    return bool(np.all(low < p) and np.all(p < high))


FORMULAS = [
    ("a + b", lambda a, b, c: a or b),
    ("a | b | c", lambda a, b, c: a or b or c),
    ("a - b - c", lambda a, b, c: a and not b and not c),
    ("a - b + c", lambda a, b, c: (a and not b) or c),
    ("a - (b - c)", lambda a, b, c: a and not (b and not c)),
    ("a & b", lambda a, b, c: a and b),
    ("a ^ b ^ c", lambda a, b, c: a ^ b ^ c),
    ("a & ~(b | c)", lambda a, b, c: a and not (b or c)),
    ("a | b & c", lambda a, b, c: a or (b and c)),
    ("a & b + c", lambda a, b, c: a and (b or c)),
    ("0 - 1", lambda a, b, c: a and not b),
    (" ~ ( ~a | ~ b ) ", lambda a, b, c: a and b),
    ("~~a", lambda a, b, c: a),
]


@pytest.mark.parametrize(("text", "rule"), FORMULAS)
def test_formulas_mean_what_they_say(text, rule):
    mesh = genus.boolean(text, [A, B, C])
    expected = volume_by_cells(lambda *p: rule(*(in_box(m, *p) for m in (A, B, C))))
    assert mesh.volume == pytest.approx(expected, abs=1e-9)
    assert mesh.topology.closed
    assert mesh.topology.manifold


def test_a_formula_as_a_tree_is_the_formula_as_a_text():
    named = {"plate": A, "hole": B, "pin": C}
    text = genus.boolean("plate - (hole + pin)", named)
    tree = genus.boolean(("-", "plate", ("+", "hole", "pin")), named)
    numbers = genus.boolean(["-", 0, ["|", 1, 2]], [A, B, C])
    assert np.array_equal(text.vertices, tree.vertices)
    assert np.array_equal(text.faces, tree.faces)
    assert np.array_equal(text.faces, numbers.faces)
    assert genus.boolean(1, [A, B]).volume == pytest.approx(64)


@pytest.mark.parametrize(
    ("formula", "said"),
    [
        ("a -", "operand is missing"),
        ("a b", "operator is missing"),
        ("(a", "closing parenthesis"),
        ("a + d", "'d' is no operand"),
        ("a + 7", "no operand 7"),
        ("", "operand is missing"),
        ("~a", "outside all operands"),
        ("(" * 5000 + "a" + ")" * 5000, "200 levels"),
        ("~" * 5000 + "a", "200 levels"),
        (("*", 0, 1), "no operator"),
        (("-",), "needs an operator"),
        ((), "needs an operator"),
        (3, "no operand 3"),
        (-1, "no operand -1"),
        ("99999999999999999999", "no operand"),
        (1.5, "a formula is"),
    ],
)
def test_what_is_no_formula_is_refused(formula, said):
    with pytest.raises(genus.InvalidInput, match=said):
        genus.boolean(formula, [A, B, C])


def test_long_formulas_are_one_step():
    cubes = [box([2 * i, 0, 0], [2 * i + 1, 1, 1]) for i in range(300)]
    mesh = genus.boolean(" + ".join(str(i) for i in range(300)), cubes)
    assert mesh.volume == pytest.approx(300)
    assert mesh.topology.components == 300


def test_union_of_meshes_is_a_mesh_and_of_solids_a_solid():
    assert isinstance(genus.union(A, B), genus.Mesh)
    assert isinstance(genus.union([A, B, C]), genus.Mesh)
    assert isinstance(genus.union(genus.cube(1), genus.cube(2)), genus.Solid)
    assert genus.union([A, B]).volume == pytest.approx(120)
    assert genus.difference([A, B, C]).volume == pytest.approx(
        genus.boolean("a-b-c", [A, B, C]).volume
    )
    assert genus.intersection(A, B).volume == pytest.approx(8)
    assert genus.union().is_empty
    with pytest.raises((TypeError, RuntimeError)):
        genus.union(A, genus.cube(1))


def test_solids_and_meshes_do_not_mix():
    cube = genus.cube(1)
    for operands in ([cube, cube.mesh()], [cube.mesh(), cube], [cube.mesh(), 3], [None]):
        for combine in (genus.union, genus.difference, genus.intersection):
            with pytest.raises(TypeError, match=f"operand {len(operands) - 1} is a"):
                combine(operands)


def test_odd_operands_give_what_theory_says_or_one_clear_error():
    vertices, faces = (
        np.array(a) for a in (genus.cube(1).mesh().vertices, genus.cube(1).mesh().faces)
    )
    cube = genus.Mesh(vertices, faces)
    other = vertices + 0.5

    def moved(k, value):
        odd = vertices.copy()
        odd[k, 1] = value
        return genus.Mesh(odd, faces)

    for bad, said in (
        (genus.Mesh(vertices, faces[:-1]), "operand 1, face .*: not closed"),
        (moved(3, np.nan), "operand 1, face .*: a coordinate is nan"),
        (moved(3, -np.inf), "operand 1, face .*: a coordinate is -inf"),
        (moved(3, 1e301), "operand 1, face .*: a coordinate is 1e.301"),
    ):
        with pytest.raises(genus.InvalidInput, match=said):
            cube - bad
    assert (cube + genus.Mesh(other, faces[:, ::-1])).volume == 1.875
    assert (cube - genus.Mesh(np.zeros((0, 3)), np.zeros((0, 3), int))).volume == 1
    assert (cube - genus.Mesh(other, np.concatenate([faces, faces]))).volume == 0.875
    assert (cube + genus.Mesh(other, np.concatenate([faces, faces[:, ::-1]]))).volume == 1
    assert (genus.Mesh(vertices * 1e100, faces) - cube).volume == pytest.approx(1e300)
    assert (cube - genus.Mesh(vertices * [1, 1, 0], faces)).volume == 1
    assert len(cube - cube) == 0


def test_a_mesh_that_comes_up_again_gives_the_same_bits():
    ball = genus.icosphere(1.0, 20)
    tools = [genus.cube(0.4).translate([0.1 * i, 0, 0.8]).mesh() for i in range(4)]
    for tool in tools + tools:
        fresh = genus.Mesh(ball.vertices, ball.faces) - tool
        again = ball - tool
        assert np.array_equal(fresh.vertices, again.vertices)
        assert np.array_equal(fresh.faces, again.faces)


def left_out(made):
    """The counts of what a call had no need to do, by name."""
    return {what: count for what, count, _ in made.explain().entries}


def test_a_boolean_of_meshes_tells_what_it_left_out():
    ball = genus.icosphere(1.0, 8)
    far = genus.Mesh(ball.vertices + [5, 0, 0], ball.faces)
    apart = left_out(genus.union([ball, far]))
    assert apart["clusters of parts that are apart solved alone"] == 2
    assert apart["faces that nothing touches passed through"] == 2 * len(ball)
    assert "operands known from an earlier call" not in apart
    tool = genus.cube(0.2).translate([0.9, 0, 0]).mesh()
    first, second = left_out(ball - tool), left_out(ball - tool)
    assert first["operands known from an earlier call"] == 1
    assert second["operands known from an earlier call"] == 2
    assert second["operands known not to cross themselves"] == 2
    assert 0 < first["faces that nothing touches passed through"] < len(ball)


def test_instances_of_a_solid_share_its_mesh():
    part = genus.solid(genus.hull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]))
    three = part + part.translate([0.2, 0.2, 0.2]) + part.translate([5, 0, 0])
    told = left_out(three.mesh())
    assert told["operands that share the mesh of an equal one"] == 2
    assert told["nested operators flattened"] == 1
    assert told["clusters of parts that are apart solved alone"] == 2


def test_faces_know_where_they_come_from():
    result = A - B
    assert result.source_operand.dtype == np.int32
    assert len(result.source_operand) == len(result.source_face) == len(result.faces)
    assert not result.source_face.flags.writeable
    for operand, mesh in enumerate((A, B)):
        faces = np.flatnonzero(result.source_operand == operand)
        assert len(faces) > 0
        for face in faces:
            corners = mesh.vertices[mesh.faces[result.source_face[face]]]
            normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
            offsets = (result.vertices[result.faces[face]] - corners[0]) @ normal
            assert np.all(offsets == 0)
    assert A.source_operand is None
    assert A.source_face is None


@pytest.mark.parametrize("normal", [[0, 0, 1], [0, -2, 0], [1, 2, 3], [-1e-3, 5, 1e-9]])
def test_both_halves_of_a_split_are_closed_and_make_the_whole(normal):
    part = (
        genus.cube(10, center=True) - genus.cylinder(h=20, r=3, center=True, fragments=24)
    ).mesh()
    rng = random.Random(5)
    for _ in range(4):
        offset = rng.uniform(-5, 5) * float(np.linalg.norm(normal))
        low, high = part.split(normal, offset)
        for half in (low, high):
            assert half.topology.closed
            assert half.topology.manifold
        assert low.volume + high.volume == pytest.approx(part.volume, rel=1e-12)
        assert np.all(low.vertices @ normal <= offset + 1e-9)
        assert np.all(high.vertices @ normal >= offset - 1e-9)
        cut = [m.vertices[m.faces[m.source_operand == 1]] for m in (low, high)]
        areas = [
            np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1).sum() / 2
            for c in cut
        ]
        assert areas[0] == pytest.approx(areas[1])


def test_a_plane_that_misses_leaves_the_mesh_whole():
    low, high = A.split([1, 1, 1], 100)
    assert low.volume == pytest.approx(64)
    assert len(high) == 0
    low, high = A.split([0, 0, 1], 0)
    assert len(low) == 0
    assert high.volume == pytest.approx(64)
    for bad in ([0, 0, 0], [math.nan, 0, 1]):
        with pytest.raises(genus.InvalidInput):
            A.split(bad, 0)


def test_slice_and_shadow():
    part = genus.boolean("a - b", [A, B])
    assert part.slice(1).area == pytest.approx(16)
    assert part.slice(3).area == pytest.approx(12)
    assert part.project().area == pytest.approx(16)
    assert part.slice(9).is_empty


SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4]]
INNER = [[1, 1], [3, 1], [3, 3], [1, 3]]


def test_regions_from_rings_arrays_and_regions():
    assert genus.Region(SQUARE).area == 16
    assert genus.Region(np.array(SQUARE)).area == 16
    assert genus.Region([SQUARE, INNER]).area == 12
    assert genus.Region([np.array(SQUARE), INNER[::-1]]).area == 12
    assert genus.Region([SQUARE, INNER], fill="nonzero").area == 16
    assert genus.Region([SQUARE, INNER[::-1]], fill="positive").area == 12
    assert genus.Region(np.array([SQUARE, INNER])).area == 12
    assert genus.Region().is_empty
    assert not genus.Region([])
    ring = genus.Region([SQUARE, INNER])
    assert genus.Region(ring) == ring
    assert ring.bounds.tolist() == [[0, 0], [4, 4]]
    [(outer, holes)] = ring.polygons()
    assert outer.shape == (4, 2)
    assert len(holes) == 1
    assert sorted(len(r) for r in ring.rings) == [4, 4]
    for wrong in ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "text", 5, [[[0]]]):
        with pytest.raises((ValueError, TypeError)):
            genus.Region(wrong)
    with pytest.raises(genus.InvalidInput):
        genus.Region([[0, 0], [math.inf, 0], [0, 1]])
    with pytest.raises(genus.InvalidInput, match="fill"):
        genus.Region(SQUARE, fill="odd")


def test_region_operators_obey_inclusion_and_exclusion():
    rng = random.Random(11)
    for _ in range(30):
        a, b = (
            genus.Region([[rng.randint(0, 20) / 7, rng.randint(0, 20) / 7] for _ in range(9)])
            for _ in range(2)
        )
        assert (a + b).area + (a & b).area == pytest.approx(a.area + b.area)
        assert (a - b).area == pytest.approx(a.area - (a & b).area)
        assert (a ^ b).area == pytest.approx((a | b).area - (a & b).area)


def test_offset_by_closed_forms():
    square = genus.Region(SQUARE)
    assert square.offset(delta=1).area == pytest.approx(36)
    assert square.offset(delta=-1).area == pytest.approx(4)
    # A chamfer cuts a corner of legs 1 - tan(45 / 2) off each of the four.
    leg = 1 - math.tan(math.pi / 8)
    assert square.offset(delta=1, chamfer=True).area == pytest.approx(36 - 2 * leg**2)
    round_area = 16 + 16 + math.pi
    for n in (16, 64):
        facets = n / 2 * math.sin(2 * math.pi / n)
        assert square.offset(1, fragments=n).area == pytest.approx(32 + facets)
    assert square.offset(r=1, tolerance=1e-6).area == pytest.approx(round_area, abs=1e-5)
    assert square.offset(-3).is_empty
    with pytest.raises(genus.InvalidInput):
        square.offset(1, delta=1)
    with pytest.raises(genus.InvalidInput):
        square.offset()


def test_regions_move_and_turn():
    shape = genus.Region([[0, 0], [3, 0], [0, 1]])
    assert shape.translate([1, 2]).bounds.tolist() == [[1, 2], [4, 3]]
    assert shape.rotate(90).bounds.tolist() == [[-1, 0], [0, 3]]
    assert shape.scale([2, 3]).area == pytest.approx(9)
    assert shape.mirror([1, 0]).bounds.tolist() == [[-3, 0], [0, 1]]
    assert shape.mirror([1, 0]).area == shape.area
    assert (shape + shape.mirror([1, 0])).area == pytest.approx(3)
    assert genus.Region([SQUARE, INNER]).hull().area == 16
    assert shape.contains([[0, 0], [1, 0.5], [3, 1]]).tolist() == [True, True, False]
    with pytest.raises(genus.InvalidInput):
        shape.scale(0)


def test_extrusions_have_the_volumes_of_prisms():
    ring = genus.Region([SQUARE, INNER])
    mesh = genus.extrude(ring, 5, center=True).mesh()
    assert mesh.volume == pytest.approx(60)
    assert mesh.topology.genus == 1
    assert mesh.bounds[:, 2].tolist() == [-2.5, 2.5]
    # A frustum: h / 3 (A + B + sqrt(A B)).
    assert genus.extrude(SQUARE, 3, scale=0.5).mesh().volume == pytest.approx(16 + 4 + 8)
    assert genus.extrude(SQUARE, 3, scale=0).mesh().volume == pytest.approx(16)
    with pytest.raises(genus.InvalidInput):
        genus.extrude(SQUARE, -1)
    assert genus.extrude([], 1).is_empty


def test_a_twisted_prism_keeps_its_volume_within_the_tolerance():
    # Sections of a twisted prism have the area of the profile.
    square = [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    for tolerance in (0.05, 0.01):
        solid = genus.extrude(square, 4, twist=90, tolerance=tolerance)
        mesh = solid.mesh(tolerance=2 * tolerance)
        assert mesh.error.bound <= 2 * tolerance
        assert abs(mesh.volume - 16) <= tolerance * 4 * 8
    # Points of the true wall, section by section, are that near.
    corner = np.array([1.0, 1.0, 0.0])
    for z in np.linspace(0, 4, 23):
        turn = -math.radians(90 * z / 4)
        x = corner[0] * math.cos(turn) - corner[1] * math.sin(turn)
        y = corner[0] * math.sin(turn) + corner[1] * math.cos(turn)
        away = np.linalg.norm(mesh.vertices - [x, y, z], axis=1).min()
        assert away < 4 / 25
    assert len(genus.extrude(square, 4, twist=90, slices=3).mesh().vertices) == 16


def test_revolved_rings_have_pappus_volume():
    profile = [[2, 0], [3, 0], [3, 1], [2, 1]]
    exact = 2 * math.pi * 2.5
    mesh = genus.revolve(profile, tolerance=1e-3).mesh(tolerance=2e-3)
    assert mesh.topology.genus == 1
    assert mesh.volume == pytest.approx(exact, rel=1e-3)
    quarter = genus.revolve(profile, 90, tolerance=1e-3).mesh(tolerance=2e-3)
    assert quarter.topology.genus == 0
    assert quarter.volume == pytest.approx(exact / 4, rel=1e-3)
    low, high = quarter.bounds
    assert low == pytest.approx([0, 0, 0], abs=1e-12)
    assert high == pytest.approx([3, 3, 1])
    with pytest.raises(genus.InvalidInput):
        genus.revolve([[-1, 0], [1, 0], [1, 1]])


def test_hulls_and_sums():
    cubes = [genus.cube(1).translate([3 * i, 0, 0]) for i in range(3)]
    assert genus.hull(*cubes).mesh().volume == pytest.approx(7)
    assert genus.hull(cubes).mesh().volume == pytest.approx(7)
    # The hull of two balls: a cylinder with half a ball at each end.
    capsule = genus.hull(genus.sphere(1), genus.sphere(1).translate([0, 0, 5]), tolerance=1e-3)
    assert capsule.mesh(tolerance=0.01).volume == pytest.approx(math.pi * (5 + 4 / 3), rel=2e-3)
    assert genus.hull().is_empty
    # A cube rolled over by a ball: Steiner's formula.
    rounded = genus.minkowski(genus.cube(2), genus.sphere(0.5), tolerance=1e-3)
    steiner = 8 + 24 * 0.5 + 6 * math.pi * 0.25 + 4 / 3 * math.pi * 0.125
    assert rounded.mesh(tolerance=0.01).volume == pytest.approx(steiner, rel=2e-3)
    ring = genus.extrude([SQUARE, INNER], 1)
    grown = genus.minkowski(ring, genus.cube(0.5)).mesh()
    assert grown.volume == pytest.approx((4.5**2 - 1.5**2) * 1.5)
    assert grown.topology.genus == 1
