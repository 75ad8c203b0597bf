"""genus convert: many files, units, welding, repair, checks, streams, further formats."""

import json
import re
import struct
import subprocess
import sys
from pathlib import Path

import genus
import numpy as np
import pytest

FORMATS = [f for f in genus.mesh_formats() if f != "gltf"]


@pytest.fixture
def ball():
    return genus.icosphere(r=10, parts=6)


def one_line(result) -> str:
    assert result.stderr.startswith("genus: "), result.stderr
    assert result.stderr.count("\n") == 1
    assert "Traceback" not in result.stderr
    return result.stderr


@pytest.mark.parametrize("source", FORMATS)
def test_among_all_formats(tmp_path, ball, source):
    ball.save(tmp_path / f"a.{source}")
    first = genus.load(tmp_path / f"a.{source}")
    for target in FORMATS:
        genus.convert(tmp_path / f"a.{source}", tmp_path / f"b.{target}")
        back = genus.load(tmp_path / f"b.{target}")
        assert len(back) == len(ball)
        assert back.is_closed
        # glTF is in metres: sources that state millimetres are scaled.
        factor = 1e-3 if target == "glb" and source in ("3mf", "amf") else 1.0
        assert back.volume == pytest.approx(first.volume * factor**3, rel=1e-5)


def test_patterns_and_batches(run, tmp_path, ball):
    for name in ("a.stl", "b.stl", "c.off"):
        ball.save(tmp_path / name)
    result = run("convert", "*.stl", "c.off", "--to", "ply", "--out-dir", "made/deep", "--json")
    assert result.returncode == 0, result.stderr
    done = json.loads(result.stdout)
    assert [d["to"] for d in done] == [f"made/deep/{n}.ply" for n in "abc"]
    assert all(d["vertices"] == len(ball.vertices) for d in done)
    none = run("convert", "*.obj", "--to", "ply")
    assert none.returncode == 1
    assert "*.obj: no file matches" in one_line(none)


def test_a_bad_file_does_not_stop_the_others(run, tmp_path, ball):
    ball.save(tmp_path / "a.stl")
    ball.save(tmp_path / "c.stl")
    (tmp_path / "b.stl").write_bytes((tmp_path / "a.stl").read_bytes()[:-10])
    result = run("convert", "?.stl", "--to", "OFF", "--json")
    assert result.returncode == 1
    assert "b.stl" in one_line(result)
    assert sorted(p.name for p in tmp_path.glob("*.off")) == ["a.off", "c.off"]
    assert [bool(d.get("error")) for d in json.loads(result.stdout)] == [False, True, False]


def test_units_and_scale(run, tmp_path):
    cube = genus.cube(2).mesh()
    cube.save(tmp_path / "a.stl")
    size = lambda name: float(np.ptp(genus.load(tmp_path / name).vertices, axis=0)[0])  # noqa: E731
    assert run("convert", "a.stl", "b.ply", "--from-unit", "in", "--unit", "mm").returncode == 0
    assert size("b.ply") == pytest.approx(50.8)
    assert run("convert", "a.stl", "m.glb", "--from-unit", "mm", "--scale", 3).returncode == 0
    assert size("m.glb") == pytest.approx(0.006)  # glTF is in metres
    assert run("convert", "m.glb", "c.stl", "--unit", "mm").returncode == 0
    assert size("c.stl") == pytest.approx(6)
    unknown = run("convert", "a.stl", "d.ply", "--unit", "mm")
    assert unknown.returncode == 1
    assert "a.stl: states no unit" in one_line(unknown)
    assert not (tmp_path / "d.ply").exists()
    assert run("convert", "a.stl", "d.ply", "--unit", "parsec").returncode == 2


@pytest.mark.skipif("3mf" not in genus.mesh_formats(), reason="built without zlib and expat")
def test_a_format_that_states_its_unit_keeps_it(run, tmp_path):
    genus.cube(2).mesh().save(tmp_path / "a.stl")
    assert run("convert", "a.stl", "a.3mf", "--from-unit", "in", "--scale", 2).returncode == 0
    assert genus.load(tmp_path / "a.3mf").bounds[1].tolist() == [4, 4, 4]
    assert run("convert", "a.3mf", "a.glb").returncode == 0
    assert genus.load(tmp_path / "a.glb").bounds[1] == pytest.approx([0.1016] * 3)
    assert run("convert", "a.3mf", "b.stl", "--unit", "mm").returncode == 0
    assert genus.load(tmp_path / "b.stl").bounds[1] == pytest.approx([101.6] * 3)


def test_weld_keeps_polygons_and_colours(run, tmp_path):
    (tmp_path / "two.obj").write_text(
        "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 1 0 0\nv 0 1 0 1 0 0\n"
        "v 1 0.0001 0 0 1 0\nv 2 0 0 0 1 0\nv 2 1 0 0 1 0\nv 1 1 0 0 1 0\nf 1 2 3 4\nf 5 6 7 8\n"
    )
    result = run("convert", "two.obj", "two.ply", "--weld", 0.001, "--ascii")
    assert result.returncode == 0, result.stderr
    assert "6 vertices, 2 faces; welded vertices 2" in result.stdout
    text = (tmp_path / "two.ply").read_text()
    assert "4 0 1 2 3" in text
    assert "255 0 0 255" in text
    assert "0 255 0 255" in text
    assert run("convert", "two.obj", "x.ply", "--weld", -1).returncode == 2


def test_repair_and_check(run, tmp_path, ball):
    faces = ball.faces[1:].copy()
    faces[::3] = faces[::3, ::-1]
    genus.Mesh(ball.vertices, faces).save(tmp_path / "bad.off")
    refused = run("convert", "bad.off", "x.stl", "--check")
    assert refused.returncode == 1
    assert re.search(r"bad\.off: is not the border of a solid: .*more findings", one_line(refused))
    assert not (tmp_path / "x.stl").exists()
    result = run("convert", "bad.off", "good.off", "--repair", "--check", "--json")
    assert result.returncode == 0, result.stderr
    done = json.loads(result.stdout)[0]["repair"]
    assert (done["closed_holes"], done["added_faces"], done["open_edges"]) == (1, 1, 0)
    good = genus.load(tmp_path / "good.off")
    assert good.validate() == []
    assert good.volume == pytest.approx(ball.volume)


PEAK = """
import sys
from genus.cli.__main__ import main
try:
    status = main(sys.argv[1:])
except SystemExit as end:
    status = end.code
peak = next(line for line in open("/proc/self/status") if line.startswith("VmHWM"))
print(peak.split()[1])
sys.exit(status)
"""


def peak_megabytes(tmp_path, *arguments):
    """Most memory that a command line holds at a time."""
    command = [sys.executable, "-c", PEAK, *map(str, arguments)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    return int(done.stdout.split()[-1]) / 1024


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="no /proc to read memory from")
def test_streams_take_no_memory(run, tmp_path, ball):
    """A file of 25 MB is converted in hardly more memory than one of a few thousand faces."""
    n = 500_000
    record = np.zeros(n, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    record["corners"] = np.random.default_rng(1).random((n, 3, 3))
    with open(tmp_path / "large.stl", "wb") as file:
        file.write(b"\0" * 80 + struct.pack("<I", n))
        record.tofile(file)
    for target in ("out.stl", "out.ply"):
        result = run("convert", "large.stl", target, "--stream", "--json")
        assert result.returncode == 0, result.stderr
        assert json.loads(result.stdout)[0] == {
            "from": "large.stl", "to": target, "vertices": 3 * n, "faces": n, "streamed": True,
        }  # fmt: skip
    ball.save(tmp_path / "small.stl")
    small = peak_megabytes(tmp_path, "convert", "small.stl", "out2.ply", "--stream")
    large = peak_megabytes(tmp_path, "convert", "large.stl", "out2.ply", "--stream")
    assert large - small < 10, f"{small} and {large} MB"
    assert len(genus.load(tmp_path / "out.ply")) == n
    body = np.fromfile(tmp_path / "out.stl", record.dtype, offset=84)
    np.testing.assert_array_equal(body["corners"], record["corners"])
    both = run("convert", "large.stl", "x.stl", "--stream", "--repair")
    assert both.returncode == 2
    assert "need the whole file" in one_line(both)


def test_the_same_name_is_replaced_whole(run, tmp_path, ball):
    ball.save(tmp_path / "a.stl")
    assert run("convert", "a.stl", "a.stl", "--scale", 2).returncode == 0
    assert genus.load(tmp_path / "a.stl").volume == pytest.approx(8 * ball.volume, rel=1e-6)
    assert [p.name for p in tmp_path.iterdir()] == ["a.stl"]


def test_further_formats_name_what_they_need(run, tmp_path, ball, monkeypatch):
    ball.save(tmp_path / "a.stl")
    (tmp_path / "meshio.py").write_text("raise ImportError\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=":")
    result = run("convert", "a.stl", "a.vtk")
    assert result.returncode == 1
    assert "a.vtk: .vtk files need the package meshio: pip install 'genus[formats]'" in one_line(
        result
    )


def test_further_formats(run, tmp_path):
    pytest.importorskip("meshio", reason="meshio is not installed")
    genus.prism(6, 2).save(tmp_path / "a.off")
    genus.torus_mesh(3, 1).save(tmp_path / "t.off")
    for name in ("vtk", "vtu", "mesh", "msh", "inp"):
        assert run("convert", "t.off", f"t.{name}").returncode == 0, name
        result = run("convert", f"t.{name}", "back.off", "--check")
        assert result.returncode == 0, result.stderr
        back = genus.load_polygons(tmp_path / "back.off")
        assert len(back) == 48 * 24
        assert back.topology.genus == 1
    (tmp_path / "bad.vtk").write_text("no mesh")
    bad = run("convert", "bad.vtk", "x.stl")
    assert bad.returncode == 1
    assert "bad.vtk" in one_line(bad)
    missing = run("convert", "none.vtk", "x.stl")
    assert missing.returncode == 1
    assert "none.vtk" in one_line(missing)


def test_info_tells_polygons_ratios_and_t_junctions(run, tmp_path):
    genus.prism(8, 2).save(tmp_path / "a.off")
    genus.icosphere(parts=30).save(tmp_path / "b.ply")
    result = run("info", "*.off", "*.ply", "--json")
    assert result.returncode == 0, result.stderr
    prism, ball = json.loads(result.stdout)
    assert (prism["polygons"], prism["faces"]) == (10, 28)
    # 3 F = 2 E, F ~ 2 V, E ~ 3 V, mean valence 6.
    assert 3 * ball["faces"] == 2 * ball["edges"]
    assert ball["faces"] / ball["vertices"] == pytest.approx(2, rel=1e-3)
    assert ball["mean_valence"] == pytest.approx(6, rel=1e-3)
    shown = run("info", "a.off").stdout
    assert re.search(r"polygons +10", shown)
    assert "valence 5.250" in shown
    corners = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [1, 0, 0], [1, -2, 0]]
    genus.Mesh(corners, [[0, 1, 2], [0, 4, 3], [3, 4, 1]]).save(tmp_path / "t.off")
    assert "vertex 3 lies within the open edge 0-1 of face 0" in run("info", "t.off").stdout


@pytest.mark.parametrize(
    "target", ["ply", "off", "glb", "obj", *(["3mf", "amf"] if "3mf" in FORMATS else [])]
)
def test_colours_of_faces_are_kept(tmp_path, target):
    """Where both formats have them: there and back by way of each format."""
    (tmp_path / "a.off").write_text(
        "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
        "3 0 2 1 255 0 0\n3 0 1 3 0 255 0\n3 1 2 3 0 0 255\n3 0 3 2 255 255 0\n"
    )
    genus.convert(tmp_path / "a.off", tmp_path / f"b.{target}")
    genus.convert(tmp_path / f"b.{target}", tmp_path / "c.off")
    mesh = genus.load(tmp_path / "c.off")
    rows = [row.split() for row in (tmp_path / "c.off").read_text().splitlines()]
    faces = [row for row in rows if len(row) >= 7 and row[0] == "3"]
    middles = {
        tuple(np.round(mesh.vertices[[int(v) for v in row[1:4]]].sum(axis=0), 6)): row[4:7]
        for row in faces
    }
    assert middles == {
        (1, 1, 0): ["255", "0", "0"],
        (1, 0, 1): ["0", "255", "0"],
        (1, 1, 1): ["0", "0", "255"],
        (0, 1, 1): ["255", "255", "0"],
    }
