"""Long calls: progress is told, other threads run, Ctrl-C and errors of the listener stop them."""

import signal
import subprocess
import sys
import textwrap
import threading
import time

import genus
import pytest

# Takes minutes if nobody stops it.
ENDLESS = "genus.union([genus.torus(3, 1).rotate([i, 2 * i, 0]) for i in range(40)]).mesh(1e-6)"


def endless(progress=None):
    tori = [genus.torus(3, 1).rotate([i, 2 * i, 0]) for i in range(40)]
    return genus.union(tori).mesh(1e-6, progress=progress, max_triangles=2_000_000_000)


def test_progress_tells_stages_and_shares():
    news = []
    solid = genus.sphere(10) - genus.cylinder(h=30, r=3, center=True)
    solid.mesh(tolerance=3e-5, progress=lambda stage, done: news.append((stage, done)))
    assert news  # every 50 ms, and this takes some hundreds
    assert all(isinstance(stage, str) and 0 <= done <= 1 for stage, done in news)


def test_an_error_of_the_listener_stops_the_call():
    class Enough(Exception):
        pass

    def listener(stage, done):
        raise Enough

    start = time.monotonic()
    with pytest.raises(Enough):
        endless(listener)
    assert time.monotonic() - start < 5


def test_other_threads_run_meanwhile():
    ticks = 0
    running = True

    def count():
        nonlocal ticks
        while running:
            ticks += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    try:
        before = ticks
        genus.sphere(10).mesh(tolerance=1e-4)  # a tenth of a second
        assert ticks > before + 5
    finally:
        running = False
        thread.join()


@pytest.mark.parametrize("delay", [0.4, 1.0, 2.0])
def test_ctrl_c_stops_a_long_call_soon(delay):
    script = textwrap.dedent(f"""
        import sys, time, genus
        print("ready", flush=True)
        try:
            {ENDLESS}
        except KeyboardInterrupt:
            print(repr(time.time()), flush=True)
            sys.exit(42)
    """)
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline() == "ready\n"
        time.sleep(delay)
        sent = time.time()
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=20)
    finally:
        process.kill()
        process.__exit__(None, None, None)  # closes its pipes
    assert process.returncode == 42
    took = float(output) - sent
    print(f"stopped after {took:.3f} s")
    assert took < 0.5  # 0.2 s promised; the machine may be busy
