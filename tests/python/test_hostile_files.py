"""Hostile mesh files: one line each and exit status 1, within a memory cap."""

import io
import json
import os
import resource
import struct
import subprocess
import sys
import zipfile

import genus

CAP = 1 << 30  # bytes of address space, for all files one after the other
XML = {"3mf", "amf"} <= set(genus.mesh_formats())


def gltf(**parts):
    return json.dumps({"asset": {"version": "2.0"}, **parts}).encode()


def glb(text, body=b""):
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if body:
        chunks += struct.pack("<II", len(body), 0x004E4942) + body
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def zipped(name, content):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, content)
    return out.getvalue()


def model(body):
    return (
        '<?xml version="1.0"?><model unit="millimeter" '
        'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">'
        f"{body}</model>"
    )


def three_mf(body):
    return zipped("3D/3dmodel.model", model(body))


HUGE = 2**60
PLY = (
    "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
)


def triangle(count=3, offset=0, buffer=None):
    return gltf(
        buffers=[buffer or {"byteLength": 36, "uri": "data:;base64," + "A" * 48}],
        bufferViews=[{"buffer": 0, "byteLength": 36}],
        accessors=[
            {"bufferView": 0, "byteOffset": offset, "componentType": 5126, "count": count,
             "type": "VEC3"},
        ],
        meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}],
        nodes=[{"mesh": 0}],
        scenes=[{"nodes": [0]}],
    )  # fmt: skip


FILES = {
    "huge.ply": (PLY.format("ascii", HUGE) + "end_header\n0 0 0\n").encode(),
    "huge_binary.ply": (PLY.format("binary_little_endian", HUGE) + "end_header\n").encode(),
    "huge_list.ply": (
        PLY.format("binary_little_endian", 1)
        + "element face 1\nproperty list uint int vertex_indices\nend_header\n"
    ).encode()
    + b"\0" * 12
    + b"\xff" * 4,
    "long_header.ply": b"ply\nformat ascii 1.0\n" + b"comment x\n" * 100_000,
    "huge.off": f"OFF\n{HUGE} {HUGE} 0\n0 0 0\n".encode(),
    "negative.off": b"OFF\n-5 2 0\n0 0 0\n",
    "huge_face.off": b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n1152921504606846976 0 1 2\n",
    "huge_index.obj": b"v 0 0 0\nf 1152921504606846976 2 3\n",
    "endless_line.obj": b"v " + b"1" * 3_000_000,
    "count.stl": b"\0" * 80 + struct.pack("<I", 2**32 - 1) + b"\0" * 500,
    "cut.stl": b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n",
    "deep.gltf": b'{"asset": ' * 200_000,
    "wide.gltf": b'{"asset":' + b"[" * 500_000,
    "huge_accessor.gltf": triangle(HUGE),
    "far_accessor.gltf": triangle(3, HUGE),
    "cycle.gltf": gltf(nodes=[{"children": [1]}, {"children": [0]}], scenes=[{"nodes": [0]}]),
    "huge_buffer.glb": glb(triangle(buffer={"byteLength": HUGE})),
    "escape.gltf": triangle(buffer={"byteLength": 36, "uri": "../../../../../../etc/passwd"}),
    "absolute.gltf": triangle(buffer={"byteLength": 36, "uri": "/etc/passwd"}),
    "doubling.gltf": gltf(
        nodes=[{"children": [i + 1, i + 1]} for i in range(60)] + [{"mesh": 0}],
        scenes=[{"nodes": [0]}],
    ),
    "cut.glb": glb(gltf(buffers=[{"byteLength": 8}]), b"12345678")[:-5],
}
if XML:
    ENTITIES = "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 12))
    FILES |= {
        "bomb.3mf": zipped("3D/3dmodel.model", b"<model>" + b" " * 300_000_000),
        "bomb.amf": zipped("x.amf", b"<amf>" + b" " * 300_000_000),
        "deep.amf": b"<amf>" + b"<a>" * 300_000,
        "deep.3mf": three_mf("<a>" * 300_000),
        "laughs.amf": f'<!DOCTYPE amf [<!ENTITY a0 "ha">{ENTITIES}]><amf>&a11;</amf>'.encode(),
        "cycle.3mf": three_mf(
            "<resources>"
            '<object id="1"><components><component objectid="2"/></components></object>'
            '<object id="2"><components><component objectid="1"/></components></object>'
            '</resources><build><item objectid="1"/></build>'
        ),
        "doubling.3mf": three_mf(
            '<resources><object id="1"><mesh><vertices><vertex x="0" y="0" z="0"/>'
            '<vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/></vertices>'
            '<triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh></object>'
            + "".join(
                f'<object id="{i}"><components><component objectid="{i - 1}"/>'
                f'<component objectid="{i - 1}"/></components></object>'
                for i in range(2, 60)
            )
            + '</resources><build><item objectid="59"/></build>'
        ),
        "index.3mf": three_mf(
            '<resources><object id="1"><mesh><vertices><vertex x="0" y="0" z="0"/></vertices>'
            f'<triangles><triangle v1="0" v2="{HUGE}" v3="0"/></triangles></mesh></object>'
            '</resources><build><item objectid="1"/></build>'
        ),
        "cut.3mf": three_mf("<resources/>")[:-30],
        "empty.3mf": zipped("other", b"x"),
    }  # fmt: skip


def capped():
    resource.setrlimit(resource.RLIMIT_AS, (CAP, CAP))


def test_each_ends_in_one_line_within_the_cap(tmp_path):
    # Stems of their own, for the outputs.
    files = {f"{name.replace('.', '_')}.{name.split('.')[1]}": c for name, c in FILES.items()}
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    environment = {**os.environ, "GENUS_THREADS": "2", "OMP_NUM_THREADS": "1",
                   "OPENBLAS_NUM_THREADS": "1"}  # fmt: skip
    for command in (["info"], ["convert", "--to", "off", "--out-dir", "made"]):
        result = subprocess.run(
            [sys.executable, "-m", "genus", *command, *files],
            cwd=tmp_path, env=environment, preexec_fn=capped, capture_output=True, text=True,
            timeout=120,
        )  # fmt: skip
        assert result.returncode == 1, result.stderr
        assert "Traceback" not in result.stderr
        lines = result.stderr.splitlines()
        assert [line.split(":")[1].strip() for line in lines] == list(files), result.stderr
        assert not any("out of memory" in line for line in lines), result.stderr
        assert all(len(line) < 400 for line in lines)
    assert not list((tmp_path / "made").iterdir())


def test_the_sound_relative_of_the_hostile_ones_is_read(tmp_path):
    """So that they fail for what is hostile in them."""
    (tmp_path / "good.gltf").write_bytes(triangle())
    assert genus.load(tmp_path / "good.gltf").vertices.tolist() == [[0, 0, 0]]
    if XML:
        (tmp_path / "good.3mf").write_bytes(
            three_mf(
                '<resources><object id="1"><mesh><vertices><vertex x="0" y="0" z="0"/>'
                '<vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/></vertices>'
                '<triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh></object>'
                '</resources><build><item objectid="1"/></build>'
            )
        )
        assert genus.load(tmp_path / "good.3mf").area == 0.5
