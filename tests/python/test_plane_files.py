"""Plane models: SVG and DXF files in and out, height maps, text."""

import contextlib
import itertools
import math
import random
import struct
import subprocess
import sys
import zlib

import genus
import numpy as np
import pytest

PAGE = 'xmlns="http://www.w3.org/2000/svg" width="100mm" height="50mm" viewBox="0 0 100 50"'


def svg(tmp_path, body, head=PAGE, before=""):
    path = tmp_path / "a.svg"
    path.write_text(f"{before}<svg {head}>{body}</svg>")
    return path


def dxf(tmp_path, *entities, blocks=()):
    """Entities as lists of codes and values, the first value their kind."""

    def lines(items):
        return [str(x) for item in items for pair in item for x in pair]

    text = ["0", "SECTION", "2", "BLOCKS", *lines(blocks), "0", "ENDSEC", "0", "SECTION", "2"]
    text += ["ENTITIES", *lines(entities), "0", "ENDSEC", "0", "EOF", ""]
    path = tmp_path / "a.dxf"
    path.write_text("\n".join(text))
    return path


def line(a, b, layer="0"):
    return [(0, "LINE"), (8, layer), (10, a[0]), (20, a[1]), (11, b[0]), (21, b[1])]


def ring_with_hole():
    outer = [[0, 0], [7.1, 0], [7.1, 5 / 3], [0, 5 / 3]]
    return genus.Region([outer, [[1, 0.5], [2, 0.5], [2, 1], [1, 1]]])


def test_dxf_reads_back_with_the_same_bits(tmp_path):
    region = ring_with_hole()
    region.save(tmp_path / "a.dxf")
    assert (genus.load_region(tmp_path / "a.dxf") ^ region).is_empty


def test_svg_reads_back_with_its_lower_left_corner_at_the_origin(tmp_path):
    region = ring_with_hole()
    region.translate([3, -4]).save(tmp_path / "a.svg")
    back = genus.load_region(tmp_path / "a.svg")
    assert back.bounds == pytest.approx(region.bounds, abs=1e-12)
    assert (back ^ region).area == pytest.approx(0, abs=1e-9)


SHAPES = [
    # body, area, bounds; y runs downward from the upper edge at 50
    ('<rect x="10" y="5" width="20" height="10"/>', 200, [[10, 35], [30, 45]]),
    ('<path d="M0,0 H10 V10 H0 z M2,2 h6v6h-6z"/>', 64, [[0, 40], [10, 50]]),
    ('<path d="m1 1 4 0 0 4-4 0z"/>', 16, [[1, 45], [5, 49]]),
    ('<path d="M1-1.5L.5.5 2,2z"/>', 1.875, None),
    ('<polygon points="0,0 10,0 10,10"/>', 50, [[0, 40], [10, 50]]),
    ('<g transform="translate(5 5)scale(2)"><rect width="3" height="4"/></g>', 48, None),
    ('<rect width="3" height="4" transform="matrix(0 1 -1 0 10 0)"/>', 12, [[6, 47], [10, 50]]),
    ('<rect width="3" height="4" transform="rotate(90,5,5) skewX(30)"/>', 12, None),
    ('<path d="M0,0 C 0,10 10,10 10,0 z"/>', 60, None),
    ('<path d="M0,0 C0,5 5,5 5,0 S 10 -5 10 0 z"/>', None, [[0, 46.25], [10, 53.75]]),
    ('<path d="M0,0 Q 5,10 10,0 z"/>', 100 / 3, None),
    ('<path d="M0,0 Q 2.5,5 5,0 T 10 0 V20 H0 z"/>', 200, None),
    ('<path d="M0,0 A 5 5 0 0 1 10 0 z"/>', 12.5 * math.pi, [[0, 50], [10, 55]]),
    ('<path d="M0,0A5 5 0 0010 0z"/>', 12.5 * math.pi, [[0, 45], [10, 50]]),
    ('<path d="M0,0 A 1 1 0 0 0 10 0 z"/>', 12.5 * math.pi, [[0, 45], [10, 50]]),
    ('<path d="M5,0 A5 5 0 1 0 0 5 L0,0 z"/>', 18.75 * math.pi, None),
    ('<ellipse cx="9" cy="9" rx="3" ry="2"/>', 6 * math.pi, [[6, 39], [12, 43]]),
    ('<rect width="10" height="8" rx="2"/>', 80 - 16 + 4 * math.pi, [[0, 42], [10, 50]]),
    ('<line x1="0" y1="9" x2="10" y2="9" stroke-width="2" stroke-linecap="butt"/>', 20, None),
    ('<polyline points="0,0 10,0 10,10" style="stroke-width:2"/>', 44, [[-1, 39], [11, 51]]),
    ('<line x2="10" stroke-width="2" stroke-linecap="round"/>', 20 + math.pi, None),
    ('<defs><rect id="r" width="5" height="5"/></defs><use href="#r" x="7"/>', 25, None),
    ('<g display="none"><rect width="5" height="5"/></g><text>none</text>', 0, None),
]


@pytest.mark.parametrize(("body", "area", "bounds"), SHAPES)
def test_svg_shapes_by_closed_forms(tmp_path, body, area, bounds):
    region = genus.load_region(svg(tmp_path, body), tolerance=1e-5)
    if area is not None:
        assert region.area == pytest.approx(area, abs=2e-3)
    if bounds is not None:
        assert region.bounds == pytest.approx(np.array(bounds), abs=1e-4)


def test_svg_pages(tmp_path):
    body = '<rect x="10" y="5" width="20" height="10"/>'
    name = 'xmlns="http://www.w3.org/2000/svg" '
    scale = 25.4 / 72
    for head, low, high in [
        ('width="100" height="50"', [10, 50 * scale - 15], [30, 50 * scale - 5]),
        ('width="100mm" height="5cm" viewBox="0 0 200 100"', [5, 42.5], [15, 47.5]),
        ('viewBox="0 0 200 100"', [10 * scale, 85 * scale], [30 * scale, 95 * scale]),
        ("", [10, -15], [30, -5]),
        ('width="100mm" height="100mm" viewBox="0 0 100 50"', [10, 60], [30, 70]),
    ]:
        path = svg(tmp_path, body, name + head)
        assert genus.load_region(path).bounds == pytest.approx(np.array([low, high]))
    assert genus.load_region(path, center=True).bounds.tolist() == [[-10, -5], [10, 5]]


LAUGHS = "".join(
    f'<g id="g{i}"><use href="#g{i - 1}"/><use href="#g{i - 1}"/></g>' for i in range(60)
)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "<svg",
        "<html/>",
        "<svg><path d='M 0 0 L'/></svg>",
        "<svg><path d='5 5'/></svg>",
        "<svg><path d='M0 0 x 5'/></svg>",
        "<svg><path d='M0 0 A 5 5 0 2 1 9 9'/></svg>",
        "<svg><rect width='1' height='1' transform='spin(4)'/></svg>",
        "<svg><rect width='1' height='1' transform='scale(1e999)'/></svg>",
        "<svg><g id='a'><use href='#a'/></g></svg>",
        f"<svg>{LAUGHS}</svg>",
        '<!DOCTYPE svg [<!ENTITY a "x"><!ENTITY b "&a;&a;">]><svg><g id="&b;"/></svg>',
        "<svg>" + "<g>" * 1000 + "</g>" * 1000 + "</svg>",
    ],
)
def test_what_is_no_svg_is_refused(tmp_path, text):
    (tmp_path / "a.svg").write_text(text)
    with pytest.raises(genus.FileError):
        genus.load_region(tmp_path / "a.svg")


def test_document_types_do_not_hurt(tmp_path):
    before = '<?xml version="1.0"?><!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "svg11.dtd" '
    before += '[<!ENTITY ns "http://www.w3.org/2000/svg">]>'
    path = svg(tmp_path, "<rect width='2' height='3'/>", 'xmlns="&ns;"', before)
    assert genus.load_region(path).area == 6


def test_dxf_entities_by_closed_forms(tmp_path):
    corners = [(0, 0), (4, 0), (4, 3), (0, 3)]
    square = [line(corners[i], corners[(i + 1) % 4]) for i in (2, 0, 3, 1)]
    assert genus.load_region(dxf(tmp_path, *square)).area == pytest.approx(12)
    turned = [line(corners[1], corners[0]), *square[2:], square[0]]
    assert genus.load_region(dxf(tmp_path, *turned)).area == pytest.approx(12)
    circle = [(0, "CIRCLE"), (8, "c"), (10, 5), (20, 5), (40, 3)]
    load = genus.load_region
    disc = load(dxf(tmp_path, circle), tolerance=1e-5)
    assert disc.area == pytest.approx(9 * math.pi, abs=1e-3)
    half = [(0, "ARC"), (8, "c"), (10, 0), (20, 0), (40, 2), (50, 270), (51, 90)]
    lid = line((0, -2), (0, 2))
    assert load(dxf(tmp_path, half, lid), tolerance=1e-5).area == pytest.approx(
        2 * math.pi, abs=1e-3
    )
    ellipse = [(0, "ELLIPSE"), (8, "c"), (10, 1), (20, 1), (11, 0), (21, 4), (40, 0.5)]
    assert load(dxf(tmp_path, ellipse), tolerance=1e-5).area == pytest.approx(8 * math.pi, abs=1e-3)
    # A square with one side bulged to half a circle.
    pairs = [
        (70, 1),
        (10, 0),
        (20, 0),
        (42, 1),
        (10, 2),
        (20, 0),
        (10, 2),
        (20, 2),
        (10, 0),
        (20, 2),
    ]
    bulged = [(0, "LWPOLYLINE"), (8, "p"), *pairs]
    region = load(dxf(tmp_path, bulged), tolerance=1e-5)
    assert region.area == pytest.approx(4 + math.pi / 2, abs=1e-3)
    assert region.bounds == pytest.approx(np.array([[0, -1], [2, 2]]), abs=1e-3)
    vertices = [[(0, "VERTEX"), (8, "p"), (10, x), (20, y)] for x, y in corners]
    old = [[(0, "POLYLINE"), (8, "p"), (70, 1)], *vertices, [(0, "SEQEND")]]
    assert load(dxf(tmp_path, *old)).area == pytest.approx(12)
    block = [[(0, "BLOCK"), (2, "B"), (10, 1), (20, 0)], *square, [(0, "ENDBLK")]]
    insert = [(0, "INSERT"), (2, "B"), (8, "0"), (10, 10), (20, 0), (41, 2), (42, 1), (50, 90)]
    region = load(dxf(tmp_path, insert, blocks=block))
    assert region.area == pytest.approx(24)
    assert region.bounds == pytest.approx(np.array([[7, -2], [10, 6]]), abs=1e-9)
    both = dxf(tmp_path, circle, *square)
    assert load(both, layer="0").area == pytest.approx(12)
    assert load(dxf(tmp_path, line((0, 0), (1, 1)))).is_empty
    assert load(dxf(tmp_path, *square[:3])).area == pytest.approx(12)  # closed by its last side


def test_blocks_in_each_other_are_refused(tmp_path):
    insert = [(0, "INSERT"), (2, "B"), (8, "0")]
    block = [[(0, "BLOCK"), (2, "B")], insert, insert, [(0, "ENDBLK")]]
    with pytest.raises(genus.FileError, match="blocks"):
        genus.load_region(dxf(tmp_path, insert, blocks=block))


def test_damaged_files_end_in_a_result_or_a_named_error(tmp_path):
    rng = random.Random(7)
    svg_text = (
        f'<svg {PAGE}><g transform="rotate(3)"><path d="M0,0 C 0,10 10,10 10,0 A 5 5 0 0 1 2 0 z"/>'
        '<polyline points="0,0 10,0 10,10"/><rect width="4" height="3" rx="1"/></g></svg>'
    )
    ring_with_hole().save(tmp_path / "b.dxf")
    for name, text in (("a.svg", svg_text), ("a.dxf", (tmp_path / "b.dxf").read_text())):
        for _ in range(300):
            damaged = bytearray(text.encode())
            for _ in range(rng.randint(1, 4)):
                at = rng.randrange(len(damaged))
                damaged[at : at + rng.randint(0, 3)] = bytes(
                    rng.choice(b"0123456789.-eE<>&\"'MLAzn\n \xff")
                    for _ in range(rng.randint(0, 3))
                )
            cut = damaged[: rng.randint(0, len(damaged))] if rng.random() < 0.3 else damaged
            (tmp_path / name).write_bytes(cut)
            with contextlib.suppress(genus.FileError):
                assert genus.load_region(tmp_path / name).area >= 0


def picture(width, height, kind, rows, depth=8, interlace=0):
    def chunk(name, data):
        body = name + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    head = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, interlace)
    packed = zlib.compress(b"".join(rows))
    palette = chunk(b"PLTE", bytes([0, 0, 0, 255, 255, 255, 51, 51, 51]))
    parts = [chunk(b"IHDR", head), palette, chunk(b"IDAT", packed), chunk(b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def heights(tmp_path, content, arguments=""):
    (tmp_path / "h.png").write_bytes(content)
    path = tmp_path / "m.scad"
    path.write_text(f'surface("h.png"{arguments});')
    mesh = genus.read_scad(path, tolerance=None).mesh()
    assert mesh.topology.closed
    return mesh


def test_pictures_of_all_kinds_give_the_same_heights(tmp_path):
    grey = [[0, 51, 255], [51, 255, 0], [255, 0, 51]]
    reference = heights(tmp_path, picture(3, 3, 0, [bytes([0, *row]) for row in grey]))
    # Volumes of the cells: the mean of four corners, each a step above the floor at -1.
    mean = (
        sum(sum(np.array(grey)[y : y + 2, x : x + 2].ravel()) for x in (0, 1) for y in (0, 1)) / 4
    )
    assert reference.volume == pytest.approx(mean * 100 / 255 + 4)
    color = [bytes([0, *(v for g in row for v in (g, g, g))]) for row in grey]
    with_alpha = [bytes([0, *(v for g in row for v in (g, g, g, 9))]) for row in grey]
    grey_alpha = [bytes([0, *(v for g in row for v in (g, 9))]) for row in grey]
    wide = [bytes([0, *(v for g in row for v in (g, 77))]) for row in grey]
    number = {0: 0, 255: 1, 51: 2}
    palette = [bytes([0, *(number[g] for g in row)]) for row in grey]
    small = [bytes([0, sum(number[g] << 6 - 2 * i for i, g in enumerate(row))]) for row in grey]
    filtered = [
        bytes([1, row[0], *(b - a & 255 for a, b in itertools.pairwise(row))]) for row in grey
    ]
    up = [bytes([2, *(b - a & 255 for a, b in zip([0, 0, 0], grey[0], strict=True))])]
    up += [
        bytes([2, *(b - a & 255 for a, b in zip(x, y, strict=True))])
        for x, y in itertools.pairwise(grey)
    ]
    passes = [
        (0, 0, 8, 8),
        (4, 0, 8, 8),
        (0, 4, 4, 8),
        (2, 0, 4, 4),
        (0, 2, 2, 4),
        (1, 0, 2, 2),
        (0, 1, 1, 2),
    ]
    woven = [
        bytes([0, *(grey[y][x] for x in range(x0, 3, dx))])
        for x0, y0, dx, dy in passes
        for y in range(y0, 3, dy)
        if range(x0, 3, dx)
    ]
    for content in [
        picture(3, 3, 2, color),
        picture(3, 3, 6, with_alpha),
        picture(3, 3, 4, grey_alpha),
        picture(3, 3, 0, wide, depth=16),
        picture(3, 3, 3, palette),
        picture(3, 3, 3, small, depth=2),
        picture(3, 3, 0, filtered),
        picture(3, 3, 0, up),
        picture(3, 3, 0, woven, interlace=1),
    ]:
        mesh = heights(tmp_path, content)
        assert mesh.volume == pytest.approx(reference.volume)
        assert mesh.bounds == pytest.approx(reference.bounds)
    turned = heights(tmp_path, picture(3, 3, 2, color), ", invert = true, center = true")
    assert turned.bounds[1].tolist() == pytest.approx([1, 1, 100 / 255])


def test_damaged_pictures_end_in_a_named_error(tmp_path):
    good = picture(3, 2, 0, [bytes([4, 1, 2, 3]), bytes([3, 4, 5, 6])])
    for cut in range(8, len(good) - 1):
        with pytest.raises(genus.ModelError):
            heights(tmp_path, good[:cut])
    for bad in [
        picture(100_000, 100_000, 0, [b""]),
        picture(3, 2, 5, [b""]),
        picture(3, 2, 0, [bytes([9, 1, 2, 3])] * 2),
        picture(0, 2, 0, [b""]),
        picture(3, 2, 3, [bytes([0, 1, 2, 3])] * 2),
    ]:
        with pytest.raises(genus.ModelError):
            heights(tmp_path, bad)


def test_number_files_are_height_maps(tmp_path):
    (tmp_path / "h.dat").write_text("# rows from the back\n5 6 7\n\n1 2 3\n")
    (tmp_path / "m.scad").write_text('surface("h.dat");')
    mesh = genus.read_scad(tmp_path / "m.scad", tolerance=None).mesh()
    assert mesh.volume == pytest.approx((1 + 2 + 5 + 6) / 4 + (2 + 3 + 6 + 7) / 4)
    assert mesh.bounds.tolist() == [[0, 0, 0], [2, 1, 7]]
    (tmp_path / "h.dat").write_text("1 2\n3 x\n")
    with pytest.raises(genus.ModelError, match=r"h\.dat:2"):
        genus.read_scad(tmp_path / "m.scad")


def region_of(text, **more):
    try:
        model = genus.run_scad(text, plane=True, **more)
    except genus.ModelError as error:
        if "built without" in str(error):
            pytest.skip("built without FreeType and HarfBuzz")
        raise
    assert model.region is not None
    return model.region


def test_letters_have_their_holes_and_sizes():
    o = region_of('text("O", size = 20, $fn = 64);')
    assert len(o.rings) == 2
    # Round letters reach a little beyond the height of capitals, which is about the size.
    assert o.bounds[1, 1] - o.bounds[0, 1] == pytest.approx(20, rel=0.1)
    assert region_of('text("O", size = 40, $fn = 64);').area == pytest.approx(4 * o.area)
    assert genus.run_scad('text("");', plane=True).solid.is_empty
    two = region_of('text("OO", size = 20, $fn = 64);')
    assert two.area == pytest.approx(2 * o.area)
    wide = region_of('text("OO", size = 20, spacing = 2, $fn = 64);')
    step = two.bounds[1, 0] - o.bounds[1, 0]
    assert wide.bounds[1, 0] - o.bounds[1, 0] == pytest.approx(2 * step)


def test_alignments_move_the_text():
    left = region_of('text("Ag");')
    middle, right = (
        region_of('text("Ag", halign = "center");'),
        region_of('text("Ag", halign = "right");'),
    )
    assert left.bounds[0, 0] - middle.bounds[0, 0] == pytest.approx(
        middle.bounds[0, 0] - right.bounds[0, 0]
    )
    assert right.bounds[1, 0] <= 0.1
    assert region_of('text("Ag", valign = "bottom");').bounds[0, 1] == pytest.approx(0, abs=0.1)
    assert region_of('text("Ag", valign = "top");').bounds[1, 1] == pytest.approx(0, abs=0.3)


def test_a_font_that_is_not_installed_is_said_so():
    region_of('text("A");')
    model = genus.run_scad('text("A", font = "No Such Font");', plane=True)
    assert "No Such Font" in model.messages[0]
    assert model.region.area > 0


def run(tmp_path, text, output):
    (tmp_path / "m.scad").write_text(text)
    command = [sys.executable, "-m", "genus", "build", "m.scad", "-o", output]
    return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)


def test_build_writes_plane_models(tmp_path):
    for output in ("out.svg", "out.dxf"):
        done = run(tmp_path, "difference() { square(4); translate([1, 1]) square(2); }", output)
        assert done.returncode == 0, done.stderr
        assert genus.load_region(tmp_path / output).area == pytest.approx(12)
    done = run(tmp_path, "cube(1);", "out2.svg")
    assert done.returncode == 1
    assert "project" in done.stderr
    assert not (tmp_path / "out2.svg").exists()
    done = run(tmp_path, "square(1);", "out.stl")
    assert done.returncode == 1
    assert "plane shape" in done.stderr


def test_drawings_in_text_models(tmp_path):
    ring_with_hole().save(tmp_path / "r.dxf")
    ring_with_hole().save(tmp_path / "r.svg")
    area = ring_with_hole().area
    for text, volume in [
        ('linear_extrude(2) import("r.dxf");', 2 * area),
        ('linear_extrude(2) import("r.svg");', 2 * area),
        ('linear_extrude(height = 2, file = "r.dxf");', 2 * area),
        ('linear_extrude(2) import("r.dxf", layer = "none");', 0),
        ('linear_extrude(1) difference() { square(9); import("r.dxf"); }', 81 - area),
    ]:
        (tmp_path / "m.scad").write_text(text)
        solid = genus.read_scad(tmp_path / "m.scad", tolerance=None)
        assert (0 if solid.is_empty else solid.mesh().volume) == pytest.approx(volume)


def test_angles_of_drawings(tmp_path):
    """The second line runs from group 15 to group 10, as in OpenSCAD's example009."""
    ends = [(13, (3, 0)), (14, (4, 1)), (15, (5, 0)), (10, (9, 0))]
    measure = [(0, "DIMENSION"), (8, "m"), (1, "turn"), (70, 2)]
    for code, (x, y) in ends:
        measure += [(code, x), (code + 10, y)]
    dxf(tmp_path, measure)
    (tmp_path / "m.scad").write_text('echo(dxf_dim(file = "a.dxf", name = "turn"));')
    assert genus.run_scad(tmp_path / "m.scad").messages == ["ECHO: 45"]


def test_measures_of_drawings(tmp_path):
    measure = [
        (0, "DIMENSION"),
        (8, "m"),
        (1, "width"),
        (70, 0),
        (13, 1),
        (23, 5),
        (14, 8),
        (24, 9),
    ]
    cross = [line((0, 0), (4, 4), "x"), line((0, 2), (4, 2), "x")]
    dxf(tmp_path, measure, *cross)
    (tmp_path / "m.scad").write_text(
        'echo(dxf_dim(file = "a.dxf", name = "width", scale = 2));'
        'echo(dxf_cross(file = "a.dxf", layer = "x"));'
        'echo(dxf_dim(file = "a.dxf", name = "none"));'
    )
    echo = genus.run_scad(tmp_path / "m.scad").messages
    assert echo[:2] == ["ECHO: 14", "ECHO: [2, 2]"]
    assert "Can't find dimension 'none'" in echo[2]
