"""Halving the tolerance ten times: measured <= bound <= tolerance each time, time follows size."""

import math
import statistics
import time

import genus
import pytest

HALVINGS = 10


def rows():
    ball = genus.sphere(50)
    holes = genus.cylinder(h=120, r=15, center=True)
    solid = ball - holes - holes.rotate([90, 0, 0])
    tolerance, table = 2.0, []
    for _ in range(HALVINGS + 1):
        start = time.process_time()
        mesh = solid.mesh(tolerance)
        table.append((tolerance, mesh, time.process_time() - start))
        tolerance /= 2
    return table


@pytest.fixture(scope="module")
def table():
    return rows()


def test_measured_is_below_bound_is_below_tolerance(table):
    for tolerance, mesh, seconds in table:
        e = mesh.error
        print(f"{tolerance:9.6f} {len(mesh):8d} {e.bound:.6f} {e.measured:.6f} {seconds:.3f} s")
        assert e.measured <= e.bound <= tolerance
        assert mesh.is_closed
        assert mesh.topology.genus == 3  # two tunnels that cross
        assert mesh.topology.components == 1


def test_time_grows_no_faster_than_triangles(table):
    """Processor time a triangle, over the coarse half of the table and over the fine half."""
    seconds_each = [s / len(mesh) for _, mesh, s in table]
    half = len(seconds_each) // 2
    coarse, fine = (statistics.median(x) for x in (seconds_each[:half], seconds_each[-half:]))
    print(f"{coarse * 1e6:.2f} and {fine * 1e6:.2f} us a triangle")
    assert fine <= coarse
    assert seconds_each[-1] <= seconds_each[0]


def test_volumes_converge_to_the_closed_form(table):
    """Ball less two crossing bores: the intersection of the bores counts once.

    A bore of radius a takes the ball's cap-and-cylinder part, in closed form; the bores have in
    common what Steinmetz's solid is, 16 a^3 / 3, which lies inside the ball.
    """
    r, a = 50.0, 15.0
    ball = 4 / 3 * math.pi * r**3
    bore = ball - 4 / 3 * math.pi * (r * r - a * a) ** 1.5
    exact = ball - 2 * bore + 16 * a**3 / 3
    for _, mesh, _ in table:
        assert abs(mesh.volume - exact) <= 1.01 * mesh.error.bound * mesh.area
