"""Files as they are met: every format in settings that are legal but unusual, one solid in all."""

import base64
import io
import json
import struct
import zipfile

import genus
import numpy as np
import pytest

XML = {"3mf", "amf"} <= set(genus.mesh_formats())

# A unit corner: volume 1/6.
POINTS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]


def facet(face, begin="facet normal 0 0 0", loop="outer loop", end="endloop", last="endfacet"):
    corners = "".join(f"  vertex\t{x:.3e} {y} {z} \r\n" for x, y, z in (POINTS[v] for v in face))
    return f"{begin}\r\n {loop}\r\n{corners} {end}\r\n{last}\r\n"


def binary_stl(header=b"", attribute=0):
    out = header.ljust(80, b" ") + struct.pack("<I", len(FACES))
    for face in FACES:
        out += b"\0" * 12 + np.array([POINTS[v] for v in face], "<f4").tobytes()
        out += struct.pack("<H", attribute)
    return out


def ply(kind, order, vertex="", extra=b"", faces="property list uchar int vertex_indices\n",
        row=lambda o, f: struct.pack(o + "B3i", 3, *f), tail="", tail_bytes=b""):  # fmt: skip
    header = (
        f"ply\nformat {kind} 1.0\ncomment by hand\nobj_info none\nelement vertex 4\n"
        f"property float x\nproperty float y\nproperty float z\n{vertex}"
        f"element face 4\n{faces}{tail}end_header\n"
    )
    body = b"".join(struct.pack(order + "3f", *p) + extra for p in POINTS)
    return header.encode() + body + b"".join(row(order, f) for f in FACES) + tail_bytes


def zipped(entries):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    return out.getvalue()


def glb(tree, body):
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    body += b"\0" * (-len(body) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(body), 0x004E4942) + body
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def interleaved():
    """Positions and colours by turns, 8-bit indices, in GLB; an unused node beside."""
    body = b"".join(struct.pack("<3f4B", *p, 255, 0, 0, 255) for p in POINTS)
    body += bytes(np.ravel(FACES).tolist())
    view = {"buffer": 0, "byteOffset": 0, "byteLength": 64, "byteStride": 16}
    indices = {"buffer": 0, "byteOffset": 64, "byteLength": 12}
    colour = {"bufferView": 0, "byteOffset": 12, "componentType": 5121, "normalized": True,
              "count": 4, "type": "VEC4"}  # fmt: skip
    return glb(
        {
            "asset": {"version": "2.0", "generator": "a test"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"name": "ä", "mesh": 0, "extras": {"x": [1, None]}}, {"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 2},
                                        "indices": 1}]}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                {"bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR"},
                colour,
            ],
            "bufferViews": [view, indices],
            "buffers": [{"byteLength": 76}],
        },
        body,
    )  # fmt: skip


def two_primitives():
    """The faces in two primitives of a mirrored node, 16- and 32-bit indices, in glTF."""
    mirrored = [(x, y, -z) for x, y, z in POINTS]
    backward = [face[::-1] for face in FACES]
    body = np.array(mirrored, "<f4").tobytes()
    body += np.array(backward[:2], "<u2").tobytes() + np.array(backward[2:], "<u4").tobytes()
    return json.dumps({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1]}, {"mesh": 0, "scale": [1, 1, -1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1},
                                   {"attributes": {"POSITION": 0}, "indices": 2, "mode": 4}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 0, "byteOffset": 48, "componentType": 5123, "count": 6,
             "type": "SCALAR"},
            {"bufferView": 0, "byteOffset": 60, "componentType": 5125, "count": 6,
             "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": len(body)}],
        "buffers": [{"byteLength": len(body), "uri": "data:application/gltf-buffer;base64,"
                     + base64.b64encode(body).decode()}],
    }).encode()  # fmt: skip


FILES = {
    "ascii.stl": "\n".join(
        ["  solid one", *(facet(f) for f in FACES[:2]), "endsolid",
         "SOLID two words", *(facet(f, "FACET NORMAL 0 0 0", "OUTER LOOP", "ENDLOOP", "EndFacet")
                              for f in FACES[2:]), "EndSolid two words\n"]
    ).encode(),
    "header.stl": binary_stl(b"solid of a program that did not know better"),
    "attributes.stl": binary_stl(b"COLOR=\xff\0\0\xff", 0x8123),
    "relative.obj": b"mtllib not there.mtl\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl gold\ns off\n"
    b"f -3 -1 -2\nv 0 0 1\ng b c\ns 1\nf -4 -3 -1\nf -3 -2 -1\nf -4 -1 \\\n -2 # end\n",
    "all_forms.obj": b"# x\r\n\tv 0 0 0 1.0\r\nv 1.e0 0 0\r\nv 0 +1 0\r\nv 0 0 1\r\nvt 0 0\r\n"
    b"vt 1 0 0\r\nvn 0 0 1\r\nf 1/1/1 3/2/1 2/1/1\r\nf 1/1 2/2 4/1\r\nf 2//1 3//1 4//1\r\n"
    b"f 1 4 3\r\np 1\r\nl 1 2 3\r\nvp 0 1\r\n",
    "colours.obj": b"".join(b"v %d %d %d 1 0 0.5\n" % p for p in POINTS)
    + b"".join(b"f %d %d %d\n" % tuple(v + 1 for v in f) for f in FACES),
    "big.ply": ply("binary_big_endian", ">", "property uchar red\nproperty uchar green\n"
                   "property uchar blue\nproperty double quality\n",
                   struct.pack(">3Bd", 1, 2, 3, 0.5),
                   "property uchar flags\nproperty list ushort uint vertex_index\n",
                   lambda o, f: struct.pack(o + "BH3I", 7, 3, *f),
                   "element edge 1\nproperty int vertex1\nproperty int vertex2\n", b"\0" * 8),
    "small.ply": ply("binary_little_endian", "<", "property list uchar float texture\n",
                     struct.pack("<B2f", 2, 0.5, 0.25),
                     "property list char uchar vertex_indices\n",
                     lambda _, f: bytes((3, *f))),
    "text.ply": b"ply\r\nformat ascii 1.0\r\ncomment \xe4\r\nelement face 4\r\n"
    b"property list uchar int vertex_indices\r\nelement vertex 4\r\nproperty double z\r\n"
    b"property double y\r\nproperty int8 junk\r\nproperty double x\r\nend_header\r\n"
    + b"".join(b"3 %d %d %d\r\n" % f for f in FACES)
    + b"".join(b"%d %d -5 %d\r\n" % (z, y, x) for x, y, z in POINTS),
    "one_line.off": b"OFF 4 4 6 # counts\n# points\n\n"
    + b"".join(b"%d %d %d\n" % p for p in POINTS)
    + b"".join(b"3 %d %d %d 255 0 0\n" % f for f in FACES),
    "colours.off": b"COFF\n4 4 0\n" + b"".join(b"%d %d %d 255 0 0 255\n" % p for p in POINTS)
    + b"".join(b"3  %d %d %d\n" % f for f in FACES),
    "normals.off": b"NOFF\n4 4 0\n" + b"".join(b"%d %d %d 0 0 1\n" % p for p in POINTS)
    + b"".join(b"3 %d %d %d\n" % f for f in FACES),
    "no_keyword.off": b"4 4 0\n" + b"".join(b"%d %d %d\n" % p for p in POINTS)
    + b"".join(b"3 %d %d %d\n" % f for f in FACES),
    "interleaved.glb": interleaved(),
    "mirrored.gltf": two_primitives(),
}  # fmt: skip
if XML:
    CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    FILES |= {
        "inches.3mf": zipped({
            "[Content_Types].xml": "<Types/>",
            "3D/3dmodel.model": "<?xml version='1.0' encoding='UTF-8'?>\n"
            f'<m:model unit="inch" xmlns:m="{CORE}" xml:lang="en"><m:metadata name="Title">&lt;'
            '</m:metadata><m:resources><m:basematerials id="5"><m:base name="red" '
            'displaycolor="#FF0000"/></m:basematerials><m:object id="1" pid="5" pindex="0">'
            "<m:mesh><m:vertices>"
            + "".join(f'<m:vertex x="{2 * x}" y="{y}" z="{z}"/>' for x, y, z in POINTS)
            + "</m:vertices><m:triangles>"
            + "".join(f'<m:triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in FACES)
            + '</m:triangles></m:mesh></m:object><m:object id="2"><m:components>'
            '<m:component objectid="1" transform="0.5 0 0 0 1 0 0 0 1 0 0 0"/></m:components>'
            '</m:object></m:resources><m:build><m:item objectid="2"/></m:build></m:model>',
        }),
        "packed.amf": zipped({"x.amf": '<?xml version="1.0"?><amf unit="millimeter"><object id="0">'
            "<mesh><vertices>"
            + "".join(f"<vertex><coordinates><x>{x}</x><y>{y}</y><z> {z}e0 </z></coordinates>"
                      "</vertex>" for x, y, z in POINTS)
            + '</vertices><volume materialid="1">'
            + "".join(f"<triangle><v1>{a}</v1><v2>{b}</v2><v3>{c}</v3></triangle>"
                      for a, b, c in FACES)
            + '</volume></mesh></object><material id="1"><color><r>1</r><g>0</g><b>0</b></color>'
            "</material></amf>"}),
    }  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_every_setting_gives_the_same_solid(tmp_path, name):
    (tmp_path / name).write_bytes(FILES[name])
    mesh = genus.load(tmp_path / name)
    assert (len(mesh.vertices), len(mesh.faces)) == (4, 4)
    assert mesh.is_closed
    assert mesh.volume == pytest.approx(1 / 6, rel=1e-6)
    np.testing.assert_allclose(mesh.bounds, [[0, 0, 0], [1, 1, 1]], atol=1e-7)


QUADS = b"".join(b"v %d %d %d\n" % (i & 1, i >> 1 & 1, i >> 2 & 1) for i in range(8))
QUADS += b"f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"


def test_quads_and_larger_faces_stay_whole_where_they_can(tmp_path):
    (tmp_path / "cube.obj").write_bytes(QUADS)
    cube = genus.load(tmp_path / "cube.obj")
    assert cube.volume == pytest.approx(1)
    for extension in ("obj", "off", "ply"):
        target = tmp_path / f"out.{extension}"
        genus.convert(tmp_path / "cube.obj", target)
        assert genus.load_polygons(target).topology.faces == 6
    # A concave face with its first corner at the notch: a fan would cover what is outside.
    (tmp_path / "dart.obj").write_bytes(b"v 1 1 0\nv 0 4 0\nv 0 0 0\nv 4 0 0\nf 1 2 3 4\n")
    assert genus.load(tmp_path / "dart.obj").area == pytest.approx(4)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("beyond.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
        ("zero.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n"),
        ("before.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -4\n"),
        ("nan.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("inf.off", b"OFF\n3 1 0\n0 0 inf\n1 0 0\n0 1 0\n3 0 1 2\n"),
        ("huge.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\n"
                     b"property double y\nproperty double z\nend_header\n1e999 0 0\n"),
        ("negative.ply", ply("binary_little_endian", "<",
                             faces="property list char int vertex_indices\n",
                             row=lambda o, f: struct.pack(o + "b3i", -3, *f))),
        ("negative_index.ply", ply("binary_little_endian", "<",
                                   row=lambda o, f: struct.pack(o + "B3i", 3, -1, *f[1:]))),
        ("nan.stl", binary_stl().replace(struct.pack("<f", 1), struct.pack("<f", float("nan")))),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(genus.FileError, match=name.replace(".", r"\.")):
        genus.load(tmp_path / name)
