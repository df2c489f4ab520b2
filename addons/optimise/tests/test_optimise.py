"""Optima against closed forms and published ones; derivatives against differences; wrong input."""

from __future__ import annotations

import builtins
import json
import math
import sys
from pathlib import Path

import numpy
import pytest
from published import BLOCK, SOLVERS, THROWN, UNITS, best

import pkgen
from conftest import ran, run_pkgen, seeds, written

pytestmark = pytest.mark.needs_addon("optimise")
FOR_BOTH = pytest.mark.parametrize("solver", SOLVERS)


@FOR_BOTH
def test_least_effort(solver: str, tmp_path: Path) -> None:
    """F = 6 - 12 t has the least integral of its square, 12, from rest to rest at 1."""
    wanted = {"integral": "F^2", "inputs": {"F": None}, "end": {"x": 1, "x'": 0}, "until": 1}
    found = best(tmp_path, BLOCK, solver, linear=True, intervals=8, **wanted)
    assert found.objective == pytest.approx(12, abs=1e-7)
    assert found.inputs["F"] == pytest.approx(6 - 12 * found.t, abs=1e-4)
    assert found.run()["integral_of_objective"][-1] == pytest.approx(12, abs=1e-6)


@FOR_BOTH
def test_least_effort_in_units(solver: str, tmp_path: Path) -> None:
    """Integral F^2 = 12 m^2 x^2/T^3: here of 2 kg, over 100 km in 10 s."""
    wanted = {
        "integral": "F^2",
        "inputs": {"F": ("-1e5 [N]", "1e5 [N]")},
        "until": "10 [s]",
    }
    wanted |= {"end": {"x": "100 [km]", "x'": 0}, "guess": {"F": (1e4, -1e4)}}
    found = best(tmp_path, UNITS, solver, linear=True, intervals=4, **wanted)
    assert found.objective == pytest.approx(12 * 4 * 1e10 / 1e3, rel=1e-6)


@FOR_BOTH
def test_least_time(solver: str, tmp_path: Path) -> None:
    wanted = {"inputs": {"F": (-1, 1)}, "end": {"x": 1, "x'": 0}, "until": (0.5, 5)}
    found = best(tmp_path, BLOCK, solver, minimise="t", intervals=6, **wanted)
    assert found.objective == found.duration == pytest.approx(2, abs=1e-7)
    assert found.inputs["F"] == pytest.approx([1, 1, 1, -1, -1, -1], abs=1e-5)


@FOR_BOTH
def test_a_parameter_that_the_start_depends_on(solver: str, tmp_path: Path) -> None:
    wanted = {"free": {"angle": (0, 1.5)}, "end": {"y": 0}, "until": (0.2, 3)}
    found = best(tmp_path, THROWN, solver, maximise="x", intervals=3, **wanted)
    assert found.parameters["angle"] == pytest.approx(math.pi / 4, abs=1e-6)
    assert found.objective == pytest.approx(100 / 9.81, rel=1e-9)
    assert found.start["x'"] == pytest.approx(10 / math.sqrt(2), abs=1e-5)


@FOR_BOTH
def test_a_start(solver: str, tmp_path: Path) -> None:
    """To x = 1 as fast as may be: x' = 2 is the most that the path allows."""
    wanted = {"free_start": ["x", "x'"], "end": {"x": 1}, "path": {"twofold": (None, 4)}}
    found = best(tmp_path, BLOCK, solver, minimise="gap", until=0.5, intervals=2, **wanted)
    assert found.objective == pytest.approx(-1, abs=1e-7)


BLOCK += "observe gap = -x'/2\nobserve twofold = 2*x'\n"
TWO = """
model two
param k = {k}
param c = {c}
param b = {b} in (0, 9)
coord x, y
state z
input u, w
kinetic (x'^2 + (1 + b*x^2)*y'^2)/2
potential k*x^2/2 + (x - y)^4/4 + cos(y)
force x = u - c*x' + z
force y = w*cos(x)
rate z = u*x - z
start x = 0.3 + b
start z = b*k
observe sum = x*y + y'*z
observe pull = u + x*x'
"""


def problem_by_chance(chance: numpy.random.Generator) -> dict:
    """A programme of two inputs, parameters, free starts, ends, paths and returns."""
    until = chance.choice([0, 1])
    return {
        "maximise": chance.choice(["x", "sum", "t"] if until else ["x", "sum"]),
        "integral": chance.choice(["", "u^2 + b*w^2 + x*y"]),
        "inputs": {"u": (-2, 2), "w": None},
        "free": {"b": (0.1, 2), "k": (0.2, 3)},
        "free_start": list(chance.choice(["x", "y", "x'", "z"], 2, replace=False)),
        "end": {"y": 0.7, "sum": (0, 2), "z": (None, 3)},
        "path": {"x": (-4, 4), "pull": (-3, 3)},
        "periodic": {"x": "sum", "z": "y'"} if chance.random() < 0.5 else ["x", "y"],
        "until": (0.5, 1.5) if until else 0.8,
        "linear": bool(chance.random() < 0.5),
        "intervals": int(chance.integers(1, 4)),
        "method": chance.choice(["dop853", "rk4"]),
    }


@pytest.mark.parametrize("seed", seeds(range(6), 6))
def test_jacobians_are_those_of_differences(seed: int, tmp_path: Path, monkeypatch) -> None:
    from pkgen_optimise import optimise

    chance = numpy.random.default_rng(seed)
    made, kept = chance.uniform(0.3, 2, 3), []

    def keep(programme, *_):
        kept.append(programme)
        raise pkgen.NumericsFailed("kept")

    monkeypatch.setattr(optimise, "solved", keep)
    model = pkgen.load(written(tmp_path, TWO.format(**dict(zip("kcb", made, strict=True)))))
    wanted = problem_by_chance(chance)
    more = {"rtol": 1e-12} if wanted["method"] == "dop853" else {"step": 0.013}
    with pytest.raises(pkgen.NumericsFailed, match="kept"):
        model.optimise(**wanted, **more)
    at = kept[0].shooting.evaluated
    z = kept[0].whole(kept[0].start + chance.normal(0, 0.05, len(kept[0].start)))
    found = at(z)
    keys = ("equalities", "equalities_by"), ("inequalities", "inequalities_by")
    for value, by in (("objective", "gradient"), *keys):
        J = numpy.atleast_2d(found[by])
        for i in kept[0].free:
            h = 1e-5 * numpy.eye(len(z))[i]
            slope = (numpy.atleast_1d(at(z + h)[value]) - at(z - h)[value]) / 2e-5
            assert J[:, i] == pytest.approx(slope, abs=2e-7 * max(1, abs(J).max())), (by, i)


SET = ["--integral", "F^2", "--input", "F", "--end", "x=1", "--until", "1"]


def test_the_command_prints_a_table_json_and_a_picture(tmp_path: Path) -> None:
    path, svg = written(tmp_path, BLOCK), tmp_path / "best.svg"
    done = ran("optimise", path, *SET, "--set", "k=0", "--end", "x'=0", "--intervals", "4")
    assert done.stdout.startswith("objective = 12.8") and "runs of an interval" in done.stdout
    done = ran("optimise", path, *SET, "--intervals", "4", "--json", "--linear", "-o", svg)
    found = json.loads(done.stdout)
    assert found["objective"] == pytest.approx(3, rel=1e-4) and len(found["inputs"]["F"]) == 5
    assert "<svg" in svg.read_text()


CONTACT = BLOCK + "contact floor: x >= -1 restitution 0.8\n"
SAMPLE = BLOCK + "input G\nsample ctrl every 0.1\n  set G = -x\nend\n"
LOOP = "model f\nsize n = 3000\ncoord q[1..n]\ninput F\nkinetic sum(q[i]'^2/2, i = 1..n)\n"
LOOP += "potential sum((q[i+1] - q[i])^2/2, i = 1..n-1)\nforce q[1] = F\n"
WRONG = [
    (BLOCK, ["--input", "G", *SET], "--input G"),
    (BLOCK, ["--free", "q=0:1", *SET], "--free q"),
    (BLOCK, ["--free-start", "q", *SET], "--free-start q"),
    (BLOCK, ["--end", "F=1", *SET], "--end F"),
    (BLOCK, ["--path", "z=0:1", *SET], "--path z"),
    (BLOCK, ["--periodic", "z", *SET], "--periodic z"),
    (BLOCK, ["--periodic", "x=z", *SET], "--periodic z"),
    (BLOCK, ["--guess", "k=0:1", *SET], "--guess k"),
    (BLOCK, ["--minimise", "z", *SET], "--minimise z"),
    (BLOCK, ["--set", "q=1", *SET], "--set q"),
    (BLOCK, ["--size", "n=a", *SET], "--size n=a: give a name and a whole number"),
    (BLOCK, ["--max-seconds", "0.001", *SET], "took more than 0.001 s of CPU time"),
    (BLOCK, ["--table", "road=a.csv", *SET], "the model has no such table"),
    (BLOCK, ["--set", "F=1", *SET], "--input: a name is there twice"),
    (BLOCK, ["--set", "k=-1", *SET], "outside its bounds"),
    (BLOCK, ["--free", "k=10:12", *SET], "the model has other bounds of k"),
    (BLOCK, ["--start", "q=1", *SET], "--start q"),
    (BLOCK, ["--path", "x=2:1", *SET], "--path x: LOW must not exceed HIGH"),
    (BLOCK, ["--path", "x=0:1:2", *SET], "give a value or LOW:HIGH"),
    (BLOCK, ["--path", "x", *SET], "--path x: give a value or LOW:HIGH"),
    (BLOCK, ["--guess", "x=1:", *SET], "--guess x: give a value or LOW:HIGH"),
    (BLOCK, ["--path", "x=a", *SET], "unknown name 'a'"),
    (BLOCK, ["--intervals", "0", *SET], "--intervals 0: a whole number from 1 to 1000"),
    (BLOCK, ["--iterations", "-1", *SET], "--iterations -1: a whole number"),
    (BLOCK, ["--solver", "sqp", *SET], "--solver sqp: ipopt, slsqp"),
    (BLOCK, ["--method", "rk5", *SET], "--method rk5"),
    (BLOCK, ["-o", "a.txt", *SET], "-o a.txt: the file's name must end in"),
    (BLOCK, [*SET[2:]], "--minimise: name a column, or give --integral"),
    (BLOCK, ["--minimise", "x", "--maximise", "x", *SET], "give one of them"),
    (BLOCK, ["--minimise", "t", *SET], "the duration is fixed"),
    (BLOCK, [*SET[:2], *SET[4:]], "nothing is free"),
    (BLOCK, [*SET[:2], "--input", "F=2", *SET[4:]], "nothing is free"),
    (BLOCK, [*SET[:-1], "0"], "--until: give a duration above 0"),
    (BLOCK, [*SET[:-1], "2:1"], "--until: give a duration above 0"),
    (BLOCK, ["--integral", "F^", *SET[2:]], "a value is missing after '^'"),
    (
        BLOCK,
        [*SET[:2], "--input", "F=-1:1", "--end", "x=9", "--until", "1"],
        "the largest violation is",
    ),
    (
        BLOCK,
        ["--minimise", "x", "--input", "F", "--until", "1", "--iterations", "9"],
        "the search ended before",
    ),
    (BLOCK, ["--iterations", "1", *SET], "--iterations"),
    (BLOCK + "force x = sin(t)\n", SET, "the model depends on time"),
    (BLOCK + "event e: t > 0.5 then x' = 0\n", SET, "the model depends on time"),
    (BLOCK + "event e: x > 0.5 then x' = t\n", SET, "the model depends on time"),
    (BLOCK + "observe o = x*t\n", ["--path", "o=0:1", *SET], "the model depends on time"),
    (BLOCK + "event e: x > 0.5 stop\n", SET, "stopped at event e"),
    (
        BLOCK + "param slope_of_input_0 = 1\n",
        ["--linear", *SET],
        "'slope_of_input_0' is declared already",
    ),
    (CONTACT, SET, "constraints, contacts or noise"),
    (SAMPLE, SET, "no derivatives"),
    (LOOP, [*SET[:4], "--end", "q[1]=1", *SET[6:]], "families kept as loops"),
]


@pytest.mark.parametrize(("text", "words", "said"), WRONG)
def test_wrong_input(text: str, words: list[str], said: str, tmp_path: Path) -> None:
    done = run_pkgen("optimise", written(tmp_path, text), *words)
    assert done.returncode != 0 and not done.stdout and said in done.stderr
    assert "Traceback" not in done.stderr and "internal" not in done.stderr


@pytest.mark.parametrize(
    ("missing", "solver", "said"),
    [("cyipopt", "ipopt", "needs cyipopt"), ("scipy.optimize", "slsqp", "needs SciPy")],
)
def test_a_solver_is_missing(missing, solver, said, tmp_path: Path, monkeypatch) -> None:
    real = builtins.__import__

    def refuses(name, *given, **more):
        if name == missing:
            raise ImportError(name)
        return real(name, *given, **more)

    monkeypatch.delitem(sys.modules, missing, raising=False)
    monkeypatch.setattr(builtins, "__import__", refuses)
    wanted = {"integral": "F^2", "inputs": {"F": None}, "end": {"x": 1}, "until": 1, "intervals": 2}
    with pytest.raises(pkgen.UsageError, match=said):
        pkgen.load(written(tmp_path, BLOCK)).optimise(solver=solver, **wanted)
    if missing == "cyipopt":
        assert pkgen.load(written(tmp_path, BLOCK)).optimise(**wanted).solver == "slsqp"


def test_a_run_leaves_the_models_parameters_as_they_were(tmp_path: Path) -> None:
    model = pkgen.load(written(tmp_path, THROWN))
    model.params["angle"] = 0.4
    found = model.optimise(maximise="x", free={"angle": (0, 1)}, until=1, intervals=2)
    found.run()
    assert model.params["angle"] == 0.4 and found.parameters["angle"] == pytest.approx(0, abs=1e-4)


SETS = """
model sets
size n = 2
table push = "push.csv" x, f linear hold
coord q[1..n]
input F
kinetic sum(q[i]'^2/2, i = 1..n)
potential sum(q[i]^2/2, i = 1..n)
force q[1] = F + push(q[1])
"""


def test_size_table_and_allowed_folders_are_those_of_the_model(tmp_path: Path) -> None:
    far, home = tmp_path / "far", tmp_path / "home"
    far.mkdir()
    home.mkdir()
    (home / "push.csv").write_text("x,f\n0,0\n9,0\n")
    (far / "push.csv").write_text("x,f\n0,1\n9,1\n")
    path, words = written(home, SETS), ["--size", "n=3", "--intervals", "2", "--json"]
    words += ["--integral", "F^2", "--input", "F", "--end", "q[1]=1", "--until", "1"]
    weak = json.loads(ran("optimise", path, *words).stdout)
    table = ["--table", f"push={far / 'push.csv'}"]
    strong = json.loads(ran("optimise", path, *words, *table).stdout)
    assert "q[3]" in weak["states"] and strong["objective"] < 0.5 * weak["objective"]
    path.write_text(SETS.replace("push.csv", str(far / "push.csv")))
    assert "lies outside of the folder" in run_pkgen("optimise", path, *words).stdout
    found = json.loads(ran("optimise", path, *words, "--allow-path", far).stdout)
    assert found["objective"] == pytest.approx(strong["objective"], rel=1e-6)


def test_maximise_makes_the_integral_largest_too(tmp_path: Path) -> None:
    """x' - integral F^2 is largest at F = 1/2: 1/4."""
    more = {"inputs": {"F": None}, "until": 1, "intervals": 2}
    found = best(tmp_path, BLOCK, maximise="x'", integral="-F^2", **more)
    assert found.objective == pytest.approx(0.25) and found.inputs["F"] == pytest.approx(0.5)


def test_parameters_begin_at_the_values_of_the_scene(tmp_path: Path) -> None:
    """The objective does not depend on the parameter."""
    text = BLOCK + "param idle = 1 in (0, 9)\nscene s\n  set idle = 3\nend\n"
    more = {"integral": "F^2", "inputs": {"F": None}, "free": {"idle": None}, "end": {"x": 1}}
    found = pkgen.load(written(tmp_path, text), "s").optimise(until=1, intervals=1, **more)
    assert found.parameters["idle"] == pytest.approx(3, abs=1e-2)
