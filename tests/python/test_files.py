"""Mesh files from Python; the formats themselves are tested in core."""

import os
from pathlib import Path

import genus
import numpy as np
import pytest

FORMATS = ["stl", "obj", "off", "ply"]


@pytest.fixture
def mesh():
    return genus.Mesh(
        [[0, 0, 0], [1.5, 0, 0], [0, 2.25, 0], [0, 0, 0.125]],
        [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    )


@pytest.mark.parametrize("ascii", [False, True])
@pytest.mark.parametrize("extension", FORMATS)
def test_what_is_saved_is_loaded(tmp_path, mesh, extension, ascii):
    path = tmp_path / f"part.{extension}"
    mesh.save(path, ascii=ascii)
    back = genus.load(path)
    np.testing.assert_array_equal(
        back.vertices[back.faces].sum(axis=(0, 1)), mesh.vertices[mesh.faces].sum(axis=(0, 1))
    )
    assert back.volume == mesh.volume
    assert back.is_closed


def test_format_goes_before_extension(tmp_path, mesh):
    mesh.save(tmp_path / "part.data", format="ply")
    assert (tmp_path / "part.data").read_bytes().startswith(b"ply")
    assert genus.load(tmp_path / "part.data").volume == mesh.volume
    with pytest.raises(genus.InvalidInput, match="stl, obj, off, ply"):
        mesh.save(tmp_path / "part.data", format="step")


def test_paths_of_any_kind(tmp_path, mesh):
    for path in (str(tmp_path / "a.stl"), tmp_path / "b.stl", os.fsencode(tmp_path / "c.stl")):
        mesh.save(path)
        assert genus.load(path).volume == mesh.volume
    odd = os.fsencode(tmp_path) + b"/\xff\xfe.ply"
    mesh.save(odd)
    assert genus.load(odd).volume == mesh.volume
    with pytest.raises(genus.FileError) as caught:
        genus.load(odd + b"missing")
    assert os.fsencode(caught.value.path) == odd + b"missing"


def test_errors_name_path_and_place(tmp_path):
    with pytest.raises(genus.FileError) as missing:
        genus.load(tmp_path / "missing.stl")
    assert missing.value.path == str(tmp_path / "missing.stl")
    assert (missing.value.line, missing.value.byte) == (None, None)
    assert isinstance(missing.value, OSError)

    bad = tmp_path / "bad.off"
    bad.write_text("OFF\n3 1 0\n0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n")
    with pytest.raises(genus.FileError) as line:
        genus.load(bad)
    assert line.value.line == 4
    assert str(bad) in str(line.value)
    assert "\n" not in str(line.value)


def test_a_failed_save_leaves_the_old_file_and_nothing_else(tmp_path, mesh):
    path = tmp_path / "part.stl"
    path.write_text("precious")
    broken = genus.Mesh([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    with pytest.raises(genus.Error):
        broken.save(path)
    assert path.read_text() == "precious"
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(genus.FileError):
        mesh.save(tmp_path / "no folder" / "part.stl")


def test_convert_keeps_polygons(tmp_path):
    source, target = tmp_path / "square.obj", tmp_path / "square.off"
    source.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    assert genus.convert(source, target, scale=2.0) == {"vertices": 4, "faces": 1}
    assert Path(target).read_text().split()[-5:] == ["4", "0", "1", "2", "3"]
    assert genus.load(target).area == 4.0
