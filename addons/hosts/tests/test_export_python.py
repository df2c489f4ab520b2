"""`pkgen export --as python`: a wheel, its tag, and what is in it against `pkgen run`."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import numpy
import pytest
from columns import RIG, ran

from conftest import ROOT, run_pkgen
from pkgen.back.library import TARGETS
from pkgen_hosts.python.make import platform_tag

PENDULUM = ROOT / "models" / "double_pendulum.lag"
WATCHED = f"""{RIG}observe power = F*x'
event low: x + (2 [m]) falling stop
event middle: x falling
"""
SCRIPT = """
import json, numpy as np, MODEL as d
m = d.Model()
before = dict(m.params), list(m.start)
m.params["m"] = 3
after = dict(m.params), list(m.start)
m.params["k"] = 7
m.inputs["F"] = 14.0
still = m.run(10, every=1, start={"x": 2.0})
del m.params["k"], m.params["m"]
m.inputs["F"] = 0.0
rows = m.run(10, every=0.25, start={"x": 3.0})
q, v = np.zeros((3, 5, 1)), np.ones((3, 5, 2))
a = m.acceleration(q, v)
y = m.rhs(0.0, m.start)
many = m.rhs(0.0, np.stack([m.start] * 9, axis=1))
def said(call, *words, **how):
    try:
        call(*words, **how)
    except Exception as error:
        return type(error).__name__, str(error)
wrong = [said(*c) for c in [
    (m.params.__setitem__, "m", 11), (m.params.__setitem__, "n", 1), (m.run, -1), (m.run, 1, 2),
    (m.run, 1, 1, "rk5"), (m.run, 1, 1, "rk4"), (m.acceleration, [1, 2], [1]),
    (rows.__getitem__, "y"), (m.run, 1, 1, None, None, None, [1.0]), (m.run, 1, 0),
    (m.run, 1, 1e-300), (m.run, 1, 1, None, 0), (m.run, 1, 1, None, float("nan")),
    (m.run, 1, 1, None, None, 0), (m.run, 1, 1, None, None, float("nan")),
]]
m.params["k"] = 8.0  # what is refused leaves nothing behind
del m.params["k"]
odd = m.run(1, every=0.3).t.tolist()
print(json.dumps([odd, before, after, still["x"].tolist(), rows.t[-1], rows["x"][-1], rows.events,
                  a.tolist(), y.tolist(), many.tolist(), wrong, dict(m.params), rows.units]))
"""


def wheel(model: Path, folder: Path, *more: str) -> Path:
    done = run_pkgen("export", model, "--as", "python", "-o", folder, *more)
    assert done.returncode == 0, done.stderr
    (path,) = folder.glob("*.whl")
    return path


def said(python: str, text: str, paths: list[Path]) -> object:
    """What a program prints that finds no compiler; numpy is this Python's."""
    numpys = Path(numpy.__file__).parents[1]
    environment = {"PATH": "", "PYTHONPATH": os.pathsep.join(map(str, [*paths, numpys]))}
    done = subprocess.run([python, "-c", text], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def unpacked(path: Path, folder: Path) -> Path:
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    return folder


def test_a_wheel_does_what_its_model_does(tmp_path: Path) -> None:
    (tmp_path / "rig.lag").write_text(WATCHED)
    path = wheel(tmp_path / "rig.lag", tmp_path, "--start", "s=0.25")
    text = SCRIPT.replace("MODEL", "rig")
    answers = said(sys.executable, text, [unpacked(path, tmp_path / "in")])
    odd, before, after, still, t, x, events, a, y, many, wrong, params, units = answers
    assert before == [{"m": 2, "k": 8}, [1, 0, 0.25]]
    assert odd == pytest.approx([0, 0.3, 0.6, 0.9, 1])
    assert after == [{"m": 3, "k": 12}, [1.5, 0, 0.25]]  # what follows m does
    assert still == pytest.approx([2] * 11, abs=1e-9)  # F = 7 x
    assert params == before[0]
    assert t == pytest.approx(numpy.arccos(-2 / 3) / 2) and x == pytest.approx(-2)
    assert [name for name, _ in events] == ["middle", "low"]
    assert events[0][1] == pytest.approx(numpy.pi / 4)
    assert numpy.array(a).shape == (3, 5, 2)
    assert y == [0, -4, 1] and many == [[value] * 9 for value in y]
    assert [kind for kind, _ in wrong] == ["ValueError"] * len(wrong)
    for part, (_, text) in zip(
        ("m is outside", "no such parameter", "positive", "at most until", "no such method",
         "give step", "shape", "no such column", "shape", "positive and finite", "1e+300",
         "the step must be positive", "the step must be positive", "rtol must be positive",
         "rtol must be positive"),
        wrong, strict=True,
    ):  # fmt: skip
        assert part in text
    assert units["power"] == "N*m/s" or units["power"] == "W"


FALL = """model fall
coord r, phi
kinetic (r'^2 + r^2*phi'^2)/2
potential -1/r + cos(phi)/10
start r = 1
"""
CENTRE = """
import json, numpy as np, fall as d
m = d.Model()
q = np.tile([0.5, 0.0], (19, 1))
q[[3, 17], 0] = 0  # one in a block of lanes, one behind the last
q[5, 1] = 1e7  # an angle that lanes leave to libm
a = m.acceleration(q, np.zeros((19, 2)))
far = abs(a[5, 1] - np.sin(1e7)/2.5)
gone = np.isnan(a).any(axis=1).nonzero()[0].tolist()
try:
    m.run(5, every=0.1)
except d.RunError as error:
    print(json.dumps([gone, far, a[4].tolist(), str(error), error.rows.t[-1]]))
"""


def test_states_and_motions_that_are_none(tmp_path: Path) -> None:
    (tmp_path / "fall.lag").write_text(FALL)
    path = wheel(tmp_path / "fall.lag", tmp_path)
    gone, far, a, why, last = said(sys.executable, CENTRE, [unpacked(path, tmp_path / "in")])
    assert gone == [3, 17] and far < 1e-9 and a == pytest.approx([-4, 0])
    assert why and 1.0 <= last <= 1.1108  # r = 0 at pi/2^1.5


DRIVEN = """model driven
param m = 2 in (0, inf)
input F, G
coord x, y
state s
kinetic m/2*(x'^2 + y'^2)
potential x^2*y
force x = F*t - 0.3*y'
force y = G
rate s = x*y + t - s
observe power = F*x' + t
observe twice = G + y
start x = 1
"""
MANY = """
import json, numpy as np, driven as d
m = d.Model(m=1.25)
m.inputs.update(F=0.7, G=-1.9)
rng = np.random.default_rng(4)
t, q, v = rng.uniform(-3, 3, 29), rng.uniform(-2, 2, (29, 2)), rng.uniform(-2, 2, (29, 3))
rhs = m.rhs(0.5, np.concatenate([q, v], axis=1).T)
print(json.dumps([x.tolist() for x in (
    t, q, v, m.acceleration(q, v, t), m.energy(q, v, t), m.observe(q, v, t), rhs)]))
"""


def test_many_states_each_with_its_time_and_inputs(tmp_path: Path) -> None:
    """In lanes and behind the last whole block of them, against the equations by hand. The model's
    own parameters are whole numbers, others need not be."""
    (tmp_path / "driven.lag").write_text(DRIVEN)
    folder = unpacked(wheel(tmp_path / "driven.lag", tmp_path), tmp_path / "in")
    answers = map(numpy.array, said(sys.executable, MANY, [folder]))
    t, q, v, a, energy, observed, rhs = answers
    (x, y), (x1, y1, s) = q.T, v.T

    def rates(t):
        forces = (0.7 * t - 0.3 * y1 - 2 * x * y) / 1.25, (-1.9 - x**2) / 1.25
        return numpy.stack([*forces, x * y + t - s])

    assert numpy.abs(a.T - rates(t)).max() < 1e-13
    assert rhs == pytest.approx(numpy.concatenate([[x1, y1], rates(0.5)]), abs=1e-13)
    assert energy == pytest.approx(0.625 * (x1**2 + y1**2) + x**2 * y, abs=1e-13)
    assert numpy.abs(observed.T - [0.7 * x1 + t, -1.9 + y]).max() < 1e-13


ROWS = """
import json, MODEL as d
rows = d.Model().run(UNTIL, every=EVERY)
print(json.dumps({name: rows[name].tolist() for name in rows.columns}))
"""


def test_the_tag_says_which_glibc_it_needs(tmp_path: Path) -> None:
    path = wheel(PENDULUM, tmp_path)
    library = unpacked(path, tmp_path / "in") / "double_pendulum" / "library.so"
    listed = subprocess.run(["nm", "-D", library], capture_output=True, text=True, check=True)
    needed = {int(line.partition("@GLIBC_2.")[2].split(".")[0]) for line in
              listed.stdout.splitlines() if "@GLIBC_2." in line}  # fmt: skip
    assert max(needed) > 5 and f"-py3-none-manylinux_2_{max(needed)}_" in path.name
    assert not [line for line in listed.stdout.splitlines() if "gsl" in line.lower()]
    assert platform_tag(b"\0GLIBC_2.4\0GLIBC_2.17\0", TARGETS["linux-x86_64"]).endswith(
        "_17_x86_64"
    )


def test_the_pages_program_prints_what_the_page_says(tmp_path: Path) -> None:
    page = (ROOT / "addons/hosts/wheel.md").read_text()
    (program,) = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    folder = unpacked(wheel(PENDULUM, tmp_path), tmp_path / "in")
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=folder, capture_output=True, text=True
    )
    assert done.stdout.splitlines() == re.findall(r"# prints (.*)", program), done.stderr


@pytest.mark.long
def test_it_installs_into_a_fresh_environment(tmp_path: Path) -> None:
    path = wheel(PENDULUM, tmp_path / "dist")
    venv.create(tmp_path / "fresh", with_pip=True)
    python = str(tmp_path / "fresh" / "bin" / "python")
    pip = [python, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps", path]
    subprocess.run(pip, check=True)
    found = said(python, ROWS.replace("MODEL", "double_pendulum").replace("UNTIL", "1.0").replace(
        "EVERY", "0.5"), [])  # fmt: skip
    rows = ran(PENDULUM, "--until", 1, "--every", 0.5)
    assert found["theta1"] == pytest.approx(rows["theta1"], abs=1e-9)
    check = [python, "-m", "pip", "show", "-f", "double_pendulum"]
    shown = subprocess.run(check, capture_output=True, text=True, check=True).stdout
    assert "library.so" in shown


def test_names_of_modules_are_refused(tmp_path: Path) -> None:
    (tmp_path / "m.lag").write_text(PENDULUM.read_text().replace("double_pendulum", "random", 1))
    done = run_pkgen("export", tmp_path / "m.lag", "--as", "python", "-o", tmp_path / "d")
    assert done.returncode == 2 and "'random' is a module of Python's" in done.stderr
    assert not (tmp_path / "d").exists()
