"""Options of `pkgen fit`: those of every model, ranges with one end, scenes, digits, messages."""

from __future__ import annotations

import json
from pathlib import Path

import numpy
import pytest

import pkgen
from conftest import ran, run_pkgen, written

pytestmark = pytest.mark.needs_addon("fit")

SPRING = """
model spring
param k = 2 in (0, 50)
param c = 0.1
coord x
kinetic x'^2/2
potential k*x^2/2
force x = -c*x'
start x = 1
scene stiff
  set k = 3.5
end
"""
ROPE = """
model rope
size n = 2
param k = 1
table push = "push.csv" t, f linear hold
coord q[1..n]
kinetic sum(q[i]'^2/2, i = 1..n)
potential k*sum(q[i]^2/2, i = 1..n)
force q[1] = push(t)
observe first = n*q[1]
"""


def swing(tmp_path: Path, text: str = SPRING, **more) -> tuple[Path, Path]:
    """A model and exact data of it at k = 4."""
    path, data = written(tmp_path, text), tmp_path / "data.csv"
    model = pkgen.load(path)
    model.params.update(k=4)
    run = model.run(3, every=0.1, **more)
    rows = [f"{t},{x}" for t, x in zip(run.t, run["x"], strict=True)]
    data.write_text("\n".join(["time,x", *rows]) + "\n")
    return path, data


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--set", "Q=3"], "--set Q: the model has no such parameter or input"),
        (["--size", "n"], "--size n: give a name and a whole number"),
        (["--free-start", "x,x"], "--free-start x: it is there twice"),
        (["--free-start", "y"], "--free-start y: it has: x, x'"),
        (["--bound", "k=60:"], "--bound k: the model has other bounds of k"),
        (["--bound", "k=3:3"], "--bound k=3:3: LOW must be below HIGH"),
        (["--max-seconds", "0"], "--max-seconds 0: give seconds"),
        (["--max-seconds", "0.001"], "compiling the model took more than 0.001 s"),
        (["--table", "road=a.csv"], "the model has no such table"),
    ],
)
def test_wrong_options(words: list[str], said: str, tmp_path: Path) -> None:
    done = run_pkgen("fit", *swing(tmp_path), "--free", "k", *words)
    assert done.returncode in (1, 2) and said in done.stderr and "internal" not in done.stderr


@pytest.mark.parametrize(("bound", "value"), [("k=2:", 4), ("k=:3", 3), ("k=:", 4)])
def test_a_range_may_have_one_end(bound: str, value: float, tmp_path: Path) -> None:
    path, data = swing(tmp_path)
    words = ["--free", "k", "--tries", "2", "--set", "c=0.1", "--bound", bound]
    done = ran("fit", path, data, *words, "--json")
    assert json.loads(done.stdout)["parameters"]["k"]["value"] == pytest.approx(value, rel=1e-6)
    low, high = (float(x) if x else None for x in bound[2:].split(":"))
    found = pkgen.load(path).fit(data, "k", bounds={"k": (low, high)}, tries=2)
    assert found.values["k"] == pytest.approx(value, rel=1e-6)


def test_size_table_and_allowed_folders_are_those_of_the_model(tmp_path: Path) -> None:
    far, home = tmp_path / "far", tmp_path / "home"
    far.mkdir()
    home.mkdir()
    (home / "push.csv").write_text("t,f\n0,0\n9,0\n")
    (far / "push.csv").write_text("t,f\n0,1\n9,1\n")
    path, data = written(home, ROPE), tmp_path / "data.csv"
    t = numpy.arange(0, 3, 0.1)
    rows = [f"{a},{b}" for a, b in zip(t, 3 * (1 - numpy.cos(2 * t)) / 4, strict=True)]
    data.write_text("\n".join(["t,first", *rows]) + "\n")
    table = ["--table", f"push={far / 'push.csv'}"]
    done = ran("fit", path, data, "--free", "k", "--tries", "2", "--size", "n=3", *table, "--json")
    assert json.loads(done.stdout)["parameters"]["k"]["value"] == pytest.approx(4, rel=1e-6)
    path.write_text(ROPE.replace("push.csv", str(far / "push.csv")))
    words = ["--free", "k", "--tries", "2", "--size", "n=3", "--json"]
    assert run_pkgen("fit", path, data, *words).returncode != 0
    done = ran("fit", path, data, *words, "--allow-path", far)
    assert json.loads(done.stdout)["parameters"]["k"]["value"] == pytest.approx(4, rel=1e-6)


def test_the_search_begins_at_the_values_of_the_scene(tmp_path: Path) -> None:
    path, data = swing(tmp_path)
    found = pkgen.load(path, "stiff").fit(data, "k", tries=0)
    assert found._problem.unknowns[0].value == 3.5 and found.values["k"] == pytest.approx(4)


def test_the_text_has_the_digits_that_its_standard_deviation_allows(tmp_path: Path) -> None:
    path, data = swing(tmp_path)
    known = {"sigma": {"x": 0.01}, "priors": {"k": (4.1, 0.05)}}
    found = pkgen.load(path).fit(data, "k", "x", tries=0, **known)
    k = found.parameters["k"]
    assert 1e-3 < k.sigma < 1e-2
    assert found.text().startswith(f"k = {k.value:.4f} +- {k.sigma:.2g}\n")
