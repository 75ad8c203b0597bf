"""The command line: files whole or not at all, one line for each fault, exit statuses."""

import json
import os
import re
import signal
import subprocess
import sys
import time

import genus
import pytest

BORED_BALL = "difference() { sphere(10); cylinder(h = 30, r = 3, center = true); }\n"


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "model.scad"
    path.write_text(BORED_BALL)
    return path


def one_line(result) -> str:
    """The error: one line on standard error, no traceback."""
    lines = [line for line in result.stderr.splitlines() if not line.startswith("WARNING")]
    assert len(lines) == 1, result.stderr
    assert lines[0].startswith("genus: ")
    assert "Traceback" not in result.stderr
    return lines[0]


@pytest.mark.parametrize("extension", ["stl", "obj", "off", "ply"])
def test_build_writes_a_closed_mesh_and_prints_its_report(run, model, tmp_path, extension):
    out = tmp_path / f"out.{extension}"
    result = run("build", model, "-o", out, "--tolerance", 0.1)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    mesh = genus.load(out)
    assert mesh.is_closed
    assert mesh.topology.genus == 1
    for row in ["triangles", "V - E + F", "genus", "components", "volume", "area", "error bound",
                "error measured", "seconds"]:  # fmt: skip
        assert re.search(rf"^ *{re.escape(row)} ", result.stdout, re.M), row
    assert re.search("certified|estimated", result.stdout)


def test_build_json_and_report_files(run, model, tmp_path):
    out = tmp_path / "out.ply"
    arguments = ["build", model, "-o", out, "--tolerance", 0.1, "--report"]
    printed = run(*arguments, tmp_path / "r.json", "--json")
    report = json.loads(printed.stdout)
    assert report == json.loads((tmp_path / "r.json").read_text())
    assert report["error"]["measured"] <= report["error"]["bound"] <= 0.1
    assert report["faces"] == len(genus.load(out))
    assert report["seconds"]["total"] >= report["seconds"]["text model"]
    table = run(*arguments, tmp_path / "r.txt", "--explain")
    assert (tmp_path / "r.txt").read_text() == table.stdout
    assert "left out" in table.stdout


def test_explain_counts_what_was_left_out(run, tmp_path):
    model = tmp_path / "m.scad"
    model.write_text(
        "module part() { difference() { cube(2); translate([50, 0, 0]) cube(1); } }"
        "union() { union() { part(); translate([1, 1, 1]) part(); } translate([20, 0, 0]) part(); }"
    )
    told = run("build", model, "-o", tmp_path / "m.stl", "--explain").stdout
    left_out = [line.split() for line in told.split("left out\n")[1].splitlines()]
    # What each module takes away misses; one union lies in another; two cubes meet in three of
    # their faces each, which are two triangles; the third is alone.
    counts = {" ".join(row[:-2]): (int(row[-2]), row[-1]) for row in left_out}
    assert counts.pop("transforms folded into leaves")[1] == "nodes"
    assert counts == {
        "nested operators flattened": (1, "nodes"),
        "part outside the reach of the operators above": (3, "leaves"),
        "faces that nothing touches passed through": (24, "faces"),
        "clusters of parts that are apart solved alone": (2, "clusters"),
    }


def test_build_echo_and_csg(run, tmp_path):
    model = tmp_path / "m.scad"
    model.write_text('echo(answer = 6 * 7, name = "x"); translate([1, 2, 3]) cube(4);')
    assert run("build", model, "-o", tmp_path / "m.echo").returncode == 0
    assert (tmp_path / "m.echo").read_text() == 'ECHO: answer = 42, name = "x"\n'
    assert run("build", model, "-o", tmp_path / "m.csg").returncode == 0
    csg = (tmp_path / "m.csg").read_text()
    assert "cube(size = [4, 4, 4], center = false)" in csg
    # The flat form is itself a model, of the same solid.
    again = tmp_path / "again.scad"
    again.write_text(csg)
    assert genus.read_scad(again).bounds().tolist() == [[1, 2, 3], [5, 6, 7]]


def test_definitions_replace_variables(run, tmp_path):
    model = tmp_path / "m.scad"
    model.write_text('w = 1; t = "a"; v = [1, 1, 1]; echo(w, t, v); cube([w, 1, 1]);')
    result = run("build", model, "-o", tmp_path / "m.off", "-D", "w=2+3", "-D", 't="b c"',
                 "-D", "v=[for (i = [0 : 2]) i]")  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert 'ECHO: 5, "b c", [0, 1, 2]' in result.stderr
    assert genus.load(tmp_path / "m.off").bounds[1].tolist() == [5, 1, 1]


def test_tolerance_of_the_model_counts_unless_another_is_given(run, tmp_path):
    model, out = tmp_path / "m.scad", tmp_path / "m.stl"
    model.write_text("$tolerance = 0.5; sphere(10);")
    own = json.loads(run("build", model, "-o", out, "--json").stdout)
    assert own["tolerance"] == 0.5
    given = json.loads(run("build", model, "-o", out, "--json", "--tolerance", 0.05).stdout)
    assert given["tolerance"] == 0.05
    assert given["faces"] > own["faces"]


FAULTS = {
    "syntax error": ("cube(1)\nsphere(;\n", 2),
    "undefined module": ("cube(1);\n  gizmo(3);\n", 2),
    "endless recursion": ("function f(x) = 1 + f(x + 1);\ncube(f(0));\n", None),
    "endless module": ("module m() { m(); }\nm();\n", None),
    "missing include": ("\ninclude <not_there.scad>\ncube(1);\n", 2),
    "missing use": ("use <not_there.scad>\ncube(1);\n", 1),
    "missing import": ('cube(1);\nimport("not_there.stl");\n', 2),
    "failed assertion": ("\n\nassert(1 > 2);\ncube(1);\n", 3),
    "unclosed brace": ("difference() {\ncube(1);\n", None),
    "bad argument": ("torus(R = 1, r = 2);\n", 1),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_of_a_model_are_one_line_with_their_place(run, tmp_path, fault):
    text, line = FAULTS[fault]
    model = tmp_path / "bad.scad"
    model.write_text(text)
    start = time.monotonic()
    result = run("build", model, "-o", tmp_path / "out.stl", "--tolerance", 0.1)
    assert time.monotonic() - start < 20
    assert result.returncode == 1
    place = re.match(r"genus: (.*?):(\d+):(\d+): \S", one_line(result))
    assert place, result.stderr
    assert place[1].endswith("bad.scad")
    assert line is None or int(place[2]) == line
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bad.scad"]


@pytest.mark.parametrize(
    ("arguments", "status", "text"),
    [
        (["build", "missing.scad", "-o", "x.stl"], 1, "missing.scad"),
        (["build", "model.scad", "-o", "no/folder/x.stl"], 1, "no/folder"),
        (["build", "model.scad", "-o", "x.docx"], 2, "x.docx"),
        (["build", "model.scad"], 2, "-o"),
        (["build", "-o", "x.stl"], 2, "MODEL.scad"),
        (["build", "model.scad", "-o", "x.stl", "--tolerance", "0"], 2, "tolerance"),
        (["build", "model.scad", "-o", "x.stl", "--tolerance", "-1"], 2, "tolerance"),
        (["build", "model.scad", "-o", "x.stl", "--tolerance", "nan"], 2, "tolerance"),
        (["build", "model.scad", "-o", "x.stl", "--tolerance", "fine"], 2, "fine"),
        (["build", "model.scad", "-o", "x.stl", "-D", "=3"], 2, "name=value"),
        (["build", "model.scad", "-o", "x.stl", "-D", "width"], 2, "name=value"),
        (["build", "model.scad", "-o", "x.stl", "--colour"], 2, "--colour"),
        (["convert", "missing.stl", "x.ply"], 1, "missing.stl"),
        (["convert", "one.stl"], 2, "IN OUT"),
        (["convert", "one.stl", "two.docx"], 2, "two.docx"),
        (["info", "missing.stl"], 1, "missing.stl"),
        (["info"], 2, "FILE"),
        (["frobnicate"], 2, "frobnicate"),
        ([], 2, "COMMAND"),
    ],
)
def test_faults_are_one_line_and_a_status(run, model, tmp_path, arguments, status, text):
    result = run(*arguments)
    assert result.returncode == status
    assert text in one_line(result)
    assert [p.name for p in tmp_path.iterdir()] == ["model.scad"]


def test_an_empty_model_is_an_answer(run, tmp_path):
    (tmp_path / "empty.scad").write_text("")
    result = run("build", "empty.scad", "-o", "empty.stl", "--tolerance", 0.1)
    assert "Traceback" not in result.stderr
    assert result.returncode == 0
    assert len(genus.load(tmp_path / "empty.stl")) == 0


def test_huge_and_tiny_tolerances(run, model, tmp_path):
    coarse = run("build", model, "-o", "coarse.stl", "--tolerance", 1e6)
    assert coarse.returncode == 0, coarse.stderr
    assert genus.load(tmp_path / "coarse.stl").is_closed
    start = time.monotonic()
    fine = run("build", model, "-o", "fine.stl", "--tolerance", 1e-13)
    assert fine.returncode == 1
    one_line(fine)
    assert time.monotonic() - start < 60
    assert not (tmp_path / "fine.stl").exists()


def test_a_failed_build_leaves_the_old_file(run, tmp_path):
    (tmp_path / "bad.scad").write_text("cube(")
    (tmp_path / "out.stl").write_text("precious")
    assert run("build", "bad.scad", "-o", "out.stl").returncode == 1
    assert (tmp_path / "out.stl").read_text() == "precious"


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_build_stops_soon_and_leaves_no_file(tmp_path, sent):
    (tmp_path / "long.scad").write_text("for (i = [0 : 40]) rotate([i, 2 * i, 0]) torus(3, 1);\n")
    process = subprocess.Popen(
        [sys.executable, "-m", "genus", "build", "long.scad", "-o", "long.stl",
         "--tolerance", "1e-6"],
        cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        time.sleep(1.5)
        assert process.poll() is None, process.communicate()
        start = time.monotonic()
        process.send_signal(sent)
        output, error = process.communicate(timeout=20)
        took = time.monotonic() - start
    finally:
        process.kill()
        process.__exit__(None, None, None)  # closes its pipes
    print(f"stopped after {took:.3f} s")
    assert process.returncode == 130
    assert (output, error) == ("", "genus: interrupted\n")
    assert took < 1.0  # 0.2 s promised, beside the interpreter's own end; the machine may be busy
    assert [p.name for p in tmp_path.iterdir()] == ["long.scad"]


def test_convert_one_and_many(run, model, tmp_path):
    assert run("build", model, "-o", "a.stl", "--tolerance", 0.2).returncode == 0
    result = run("convert", "a.stl", "b.ply", "--scale", 2)
    assert result.returncode == 0, result.stderr
    a, b = genus.load(tmp_path / "a.stl"), genus.load(tmp_path / "b.ply")
    assert b.volume == pytest.approx(8 * a.volume, rel=1e-9)
    result = run("convert", "a.stl", "b.ply", "--to", "off", "--out-dir", "made", "--json")
    assert [job["to"] for job in json.loads(result.stdout)] == ["made/a.off", "made/b.off"]
    assert genus.load(tmp_path / "made" / "b.off").is_closed
    twice = run("convert", "a.stl", "made/../a.stl", "--to", "off", "--out-dir", "made")
    assert twice.returncode == 2


def test_info_tells_topology_and_defects(run, tmp_path):
    (tmp_path / "open.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    genus.Mesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    ).save(tmp_path / "good.ply")
    result = run("info", "good.ply", "open.obj", "missing.stl")
    assert result.returncode == 1
    assert "missing.stl" in one_line(result)
    assert "4 - 6 + 4 = 2" in result.stdout
    assert re.search("defects +none", result.stdout)
    assert re.search("3 x open edge", result.stdout)
    described = json.loads(run("info", "--json", "open.obj").stdout)[0]
    assert described["boundary_loops"] == 1
    assert described["defects"][0]["count"] == 3


def test_a_closed_pipe_is_no_traceback(model, tmp_path):
    command = f"{sys.executable} -m genus build {model} -o {tmp_path}/o.stl --tolerance 0.3 | true"
    result = subprocess.run(command, shell=True, capture_output=True, text=True)
    assert result.stderr == ""


def test_help_and_version(run):
    assert run("--version").stdout == f"genus {genus.__version__}\n"
    for command in ([], ["build"], ["convert"], ["info"]):
        result = run(*command, "--help")
        assert result.returncode == 0
        assert "usage: genus" in result.stdout


def test_a_bar_is_drawn_on_a_terminal_only(model, tmp_path):
    """On a terminal a long build shows its progress; in a pipe nothing (other tests)."""
    pty = pytest.importorskip("pty")
    model.write_text("for (i = [0 : 40]) rotate([i, 2 * i, 0]) torus(3, 1);\n")
    try:
        ours, theirs = pty.openpty()
    except OSError as problem:
        pytest.skip(f"no terminal can be opened here: {problem}")
    process = subprocess.Popen(
        [sys.executable, "-m", "genus", "build", model, "-o", tmp_path / "o.stl",
         "--tolerance", "1e-6"],
        stderr=theirs, stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    os.close(theirs)
    try:
        time.sleep(3)
        process.send_signal(signal.SIGINT)
        process.wait(20)
        shown = os.read(ours, 100_000).decode()
    finally:
        process.kill()
        process.__exit__(None, None, None)  # closes its pipes
        os.close(ours)
    assert "%" in shown
