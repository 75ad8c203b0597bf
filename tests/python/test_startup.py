"""Start-up times: reported, and held only against gross mistakes such as importing numpy."""

import statistics
import subprocess
import sys
import time


def seconds(*arguments, repeats=5):
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def test_import_and_version_are_quick(record_property):
    bare = seconds("-c", "pass")
    imported = seconds("-c", "import genus") - bare
    version = seconds("-m", "genus", "--version")
    print(f"python {bare:.3f} s, import genus +{imported:.3f} s, genus --version {version:.3f} s")
    record_property("import_genus", imported)
    record_property("genus_version", version)
    assert imported < 0.3  # 0.06 promised on a quiet machine
    assert version < 0.5  # 0.1 promised


def test_import_brings_in_nothing_heavy():
    script = (
        "import sys; old = set(sys.modules); import genus; new = set(sys.modules) - old\n"
        "print(*sorted(new & set('numpy argparse json tqdm subprocess typing'.split())))"
    )
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert result.stdout.strip() == ""


def test_build_needs_no_numpy(tmp_path):
    model = tmp_path / "m.scad"
    model.write_text("cube(1);")
    script = (
        "import sys; from genus.cli.__main__ import main\n"
        f"status = main(['build', {str(model)!r}, '-o', {str(tmp_path / 'm.stl')!r}])\n"
        "print(status, 'numpy' in sys.modules, 'tqdm' in sys.modules)"
    )
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert result.stdout.splitlines()[-1] == "0 False False"
