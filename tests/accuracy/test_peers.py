"""The bearing block through other libraries: they find it closed and manifold, and their own
boolean of fine tessellations has the volume that ours has, within the stated error."""

import genus
import numpy as np
import pytest

manifold3d = pytest.importorskip("manifold3d", reason="manifold3d is not installed")
trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")

TOLERANCE = 0.05
SEGMENTS = 720


@pytest.fixture(scope="module")
def block(models, tmp_path_factory):
    """The mesh as it is in the file, and its report."""
    mesh = genus.read_scad(models / "bearing_block.scad").mesh(TOLERANCE)
    path = tmp_path_factory.mktemp("peers") / "block.stl"
    mesh.save(path)
    return mesh, path


def test_trimesh_finds_the_file_closed(block):
    mesh, path = block
    theirs = trimesh.load_mesh(path)
    assert theirs.is_watertight
    assert theirs.is_winding_consistent
    assert theirs.volume == pytest.approx(mesh.volume, rel=1e-6)  # STL keeps 7 digits
    assert theirs.euler_number == mesh.topology.euler


def test_manifold_takes_the_mesh(block):
    mesh, _ = block
    ours = manifold3d.Manifold(
        manifold3d.Mesh64(mesh.vertices.copy(), mesh.faces.astype(np.uint64))
    )
    assert ours.status() == manifold3d.Error.NoError
    assert ours.volume() == pytest.approx(mesh.volume, rel=1e-9)
    assert ours.surface_area() == pytest.approx(mesh.area, rel=1e-9)
    assert ours.genus() == mesh.topology.genus


class Tessellated:
    """The shapes of the models' scripts in manifold3d, round ones with many facets.

    A script is run with this in place of the module genus.
    """

    def __init__(self, manifold):
        self.manifold = manifold

    Solid = object

    @staticmethod
    def cube(size, center=False):
        size = (size,) * 3 if np.isscalar(size) else tuple(size)
        return Tessellated(manifold3d.Manifold.cube(size, center))

    @staticmethod
    def cylinder(h, r=None, *, d=None, center=False):
        r = d / 2 if r is None else r
        return Tessellated(manifold3d.Manifold.cylinder(h, r, r, SEGMENTS, center))

    @staticmethod
    def torus(R, r):
        turn = np.linspace(0, 2 * np.pi, SEGMENTS // 3, endpoint=False)
        ring = np.c_[R + r * np.cos(turn), r * np.sin(turn)]
        section = manifold3d.CrossSection([ring])
        return Tessellated(manifold3d.Manifold.revolve(section, SEGMENTS))

    @staticmethod
    def half_space(normal, offset):
        # A box that reaches beyond all models, its top face in the plane.
        n = np.asarray(normal, float)
        offset, n = offset / np.linalg.norm(n), n / np.linalg.norm(n)
        u = np.cross(n, [0.6, 0.8, 0.1])
        u /= np.linalg.norm(u)
        axes = np.c_[u, np.cross(n, u), n]
        box = manifold3d.Manifold.cube((800.0, 800.0, 400.0), True)
        matrix = np.c_[axes, n * (offset - 200)]
        return Tessellated(box.transform(matrix))

    @staticmethod
    def union(*solids):
        parts = [s.manifold for s in solids]
        return Tessellated(manifold3d.Manifold.batch_boolean(parts, manifold3d.OpType.Add))

    @staticmethod
    def difference(first, *others):
        return first - Tessellated.union(*others)

    def __add__(self, other):
        return Tessellated(self.manifold + other.manifold)

    def __sub__(self, other):
        return Tessellated(self.manifold - other.manifold)

    def __and__(self, other):
        return Tessellated(self.manifold ^ other.manifold)

    def translate(self, by):
        return Tessellated(self.manifold.translate(by))

    def rotate(self, angles):
        angles = [0, 0, angles] if np.isscalar(angles) else angles
        return Tessellated(self.manifold.rotate(angles))

    def mirror(self, normal):
        return Tessellated(self.manifold.mirror(normal))


def test_volume_is_that_of_a_fine_boolean(block, models, part_of, monkeypatch):
    mesh, _ = block
    monkeypatch.setitem(__import__("sys").modules, "genus", Tessellated)
    theirs = part_of("bearing_block").manifold
    assert theirs.status() == manifold3d.Error.NoError
    # Facets of the largest round shape lie this far from it.
    sagitta = 43 * (1 - np.cos(np.pi / SEGMENTS))
    allowed = (mesh.error.bound + sagitta) * 1.01 * mesh.area
    difference = abs(theirs.volume() - mesh.volume)
    print(
        f"volumes {mesh.volume:.4f} {theirs.volume():.4f}: apart {difference:.4f} of {allowed:.1f}"
    )
    assert difference <= allowed
    assert theirs.genus() == mesh.topology.genus
