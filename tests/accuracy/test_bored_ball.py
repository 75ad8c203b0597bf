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


def test_time_grows_about_as_triangles_do(table):
    """Order of growth of processor time over all rows, by least squares: one, and what the
    logarithm in the search for self-intersections and the machine's caches add."""
    triangles = [math.log(len(mesh)) for _, mesh, _ in table]
    order = statistics.linear_regression(triangles, [math.log(s) for *_, s in table]).slope
    print(f"time grows with order {order:.3f} of the triangles")
    assert order <= 1.2


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
