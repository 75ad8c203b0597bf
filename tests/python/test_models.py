"""The models of models/: text and Python give one solid, and it becomes a good mesh."""

import math
import runpy
import shutil
import subprocess
import sys

import genus
import numpy as np
import pytest

NAMES = ["bearing_block", "bracket", "die", "hinge", "knob", "pipe_tee"]
FREEFORM = ["teapot"]  # text only; tested in test_freeform.py

# Handles, by counting through holes; components.
TOPOLOGY = {
    # 4 foot holes, 6 flange holes of which each is blind or through: told by the mesh, see below.
    "die": (0, 1),
}


def test_every_model_is_tested(models):
    assert sorted(p.stem for p in models.glob("*.scad")) == sorted(NAMES + FREEFORM)
    assert sorted(p.stem for p in models.glob("*.py")) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_text_and_script_give_the_same_solid(models, part_of, name):
    text, script = genus.read_scad(models / f"{name}.scad"), part_of(name)
    low, high = script.bounds()
    points = np.random.default_rng(7).uniform(low - 1, high + 1, (50_000, 3))
    inside = script.contains(points)
    assert 0.02 < inside.mean() < 0.9
    np.testing.assert_array_equal(text.contains(points), inside)


@pytest.mark.parametrize("name", NAMES)
def test_models_become_closed_meshes_within_the_tolerance(models, part_of, name):
    tolerance = 0.1
    meshes = [s.mesh(tolerance) for s in (genus.read_scad(models / f"{name}.scad"), part_of(name))]
    for mesh in meshes:
        assert mesh.error.measured <= mesh.error.bound <= tolerance
        assert mesh.validate() == []
    text, script = meshes
    assert text.topology.genus == script.topology.genus
    assert text.topology.components == script.topology.components
    # Each is within its bound of the one exact solid.
    both = text.error.bound + script.error.bound
    assert text.distance(script).max <= both
    assert abs(text.volume - script.volume) <= both * max(text.area, script.area)


def test_topology_is_what_the_drawings_say(part_of):
    """Handles counted by hand: a hole through a body adds one, a blind one none."""
    expected = {
        "die": (0, 1),
        # 30 holes in the arm, 2 slots and a screw hole; the two ribs close two triangles? No:
        # they are solid, so the holes alone count.
        "bracket": (33, 1),
        # Knob: the shaft's hole is blind; the set screw's opens into it, which makes one handle.
        "knob": (1, 1),
        # Hinge: two leaves and a pin.
        "hinge": (None, 3),
    }
    for name, (handles, components) in expected.items():
        topology = part_of(name).mesh(0.1, measure=False).topology
        assert topology.components == components, name
        if handles is not None:
            assert topology.genus == handles, name


def test_parameters_change_the_model(models):
    solid = genus.read_scad(models / "die.scad", defines={"side": 20, "round_d": 30})
    assert math.isclose(solid.bounds()[1, 0], 10)


@pytest.mark.parametrize("name", ["die"])
def test_scripts_run_as_they_stand(models, tmp_path, name):
    script = shutil.copy(models / f"{name}.py", tmp_path)
    result = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert "error bound" in result.stdout
    assert genus.load(tmp_path / f"{name}.stl").is_closed


def test_scripts_do_nothing_when_imported(models, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in NAMES:
        runpy.run_path(str(models / f"{name}.py"), run_name="imported")
    assert list(tmp_path.iterdir()) == []
