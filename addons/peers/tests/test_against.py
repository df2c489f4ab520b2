"""`pkgen chart --against`: other packages' integrators in the same picture.

A package that is invented here, whose error and time are known, is measured as a real one is; the
expressions that packages get are those of the compiled model; and who has SciPy, heyoka or
scikit-sundae runs what the chart answers once more, by code of its own.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import json
import math
import os
import random
import sys
import time
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy
import pytest

from conftest import case
from pkgen.__main__ import main, parser_of
from pkgen.analysis.chart.measure import Program
from pkgen.cli.compilation import compile_within_limits
from pkgen.graph.written import Floats
from pkgen.run.build import build_library
from pkgen.scenes import run_settings as asked
from pkgen.scenes.compile_plan import whole
from pkgen.system.exits import UsageError
from pkgen_peers import against, command, peers
from pkgen_peers.peers import COMPILED, Motion, Peer

UNTIL = 3.0
MODEL = case("oscillator")


def motion_of(path: Path, *words: object, unroll: int | None = None) -> Motion:
    options = parser_of("chart").parse_args([str(path), *map(str, words)])
    compilation = compile_within_limits(options, unroll=unroll, use=whole(options))
    settings = asked.settings(options, compilation)
    library = build_library(compilation.files, compilation.model.name, "rk4", able=("gauss",))
    return Motion(compilation, Program(library, settings), [1.0])


SMOOTH = ("sin({})", "tanh({})", "exp(-({})^2)", "sqrt(1 + ({})^2)", "atan({})", "cos(({})^3)")
KINKED = ("abs({})", "max({}, 0.1)", "min({}, sin(t))", "({})*step({})", "sign({})*({})^2")
# Where a function of time and of what moves may stand, in each kind of what a model may have.
FREE = "coord x, y\nkinetic (x'^2 + y'^2)/2\n"
KINDS = {
    "force": f"{FREE}potential p*x^2*y^2/2 + x\nforce x = {{}}\n",
    "mass": "coord x, y\nkinetic (2 + sin({}))*x'^2/2 + y'^2/2 + x'*y'/3\npotential {}\n",
    "state": "coord x, y\nstate s\nkinetic (2 + s^2)*(x'^2 + y'^2)/2\npotential s*x\n"
    "rate s = {} - s*y'\n",
    "states": "state x, y\nrate x = y*{}\nrate y = p*x' - {}\n",
    "input": f"{FREE}input u\npotential p*u*x*y + {{}}\n",
    "constraint": f"{FREE}potential {{}}\nconstraint rod: x + 2*y = 0.2*sin(x*y)\n",
    "rotation": "rotation R\nlet w = omega(R)\nkinetic (p*w.x^2 + 2*w.y^2 + 3*w.z^2)/2\n"
    "potential {}\nstart omega(R) = [0.3, 0.2, 1]\n",
}


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_expressions_are_the_compiled_equations(kind: str, tmp_path: Path) -> None:
    """At random states, with a smooth or a kinked function of t and of what moves."""
    for seed in range(3):
        _expressions_are_those_of(kind, random.Random(f"{kind} {seed}"), tmp_path)


def _expressions_are_those_of(kind: str, chance: random.Random, folder: Path) -> None:
    places = ["x + 0.3*t", "x*y - t", "t - 0.7", "2*x - y"]
    where = "(R*[0, 0, 1]).z + t/3" if kind == "rotation" else chance.choice(places)
    function = chance.choice(SMOOTH if kind == "mass" else (*SMOOTH, *KINKED))
    body = KINDS[kind].replace("{}", function.replace("{}", where))
    path = folder / "random.lag"
    path.write_text(f"model random_{kind}\nparam p = 1.2\n{body}")
    words = ["--set", "u=0.37"] if kind == "input" else []
    motion = motion_of(path, "--set", "p=1.37", *words)
    for _ in range(20):
        t = chance.uniform(0, 2)
        y = [chance.uniform(-1, 1) for _ in motion.start]
        told = motion.expressions("floats", Floats, t, y)
        assert told == pytest.approx(motion.f(t, numpy.array(y)), rel=1e-12, abs=1e-13)
    assert motion.count == 20


# -- a package whose error and time are known ----------------------------------------------------


def invented(motion: Motion, method: str) -> peers.Integrate:
    """The oscillator in closed form, too large by the tolerance; it takes .1 ms a digit, and prints
    as compiled code does."""

    def integrate(tolerance: float, times):
        os.write(1, b"from compiled code\n")
        if method == "fails" and tolerance < 1e-5:
            raise ValueError("too small for it")
        motion.f(0.0, motion.start)
        late = time.process_time() + 1e-4 * -math.log10(tolerance)
        while time.process_time() < (late if method != "slow" else math.inf):
            motion.f(0.0, motion.start)
        motion.count = 7
        ends = times or [motion.until]
        return numpy.array([[math.cos(t) * (1 + tolerance), -math.sin(t)] for t in ends])

    return integrate


ROW = Peer("known", "math", "pip", COMPILED, {"good": 4, "fails": 4, "slow": 4}, invented)


def charted(folder: Path, *words: object) -> tuple[dict, list[dict[str, str]], str]:
    """The chart with that package: what --json says, rows of the CSV, and the page."""
    model = folder / "oscillator.lag"
    model.write_text(MODEL)
    arguments = ["chart", model, "--quick", "--until", UNTIL, "--json", "-o", folder, *words]
    kept = command.PEERS
    command.PEERS = (*peers.PEERS, ROW)
    try:
        with open(folder / "said.json", "w+") as file, redirected(file.fileno()):
            assert main(list(map(str, arguments))) == 0
    finally:
        command.PEERS = kept
    with (folder / "oscillator_chart.csv").open() as file:
        rows = list(csv.DictReader(file))
    page = folder / "oscillator_chart.html"
    page = page.read_text(encoding="utf-8") if page.exists() else ""
    return json.loads((folder / "said.json").read_text()), rows, page


@contextlib.contextmanager
def redirected(file: int):
    """Standard output, of compiled code too."""
    sys.stdout.flush()
    kept, printed = os.dup(1), sys.stdout
    os.dup2(file, 1)
    sys.stdout = os.fdopen(os.dup(file), "w")
    try:
        yield
    finally:
        sys.stdout.close()
        sys.stdout = printed
        os.dup2(kept, 1)
        os.close(kept)


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory):
    """One chart beside all packages that there are."""
    names = ",".join(p.name for p in (*peers.PEERS, ROW) if not p.missing)
    words = ["--methods", "rk4,dop853", "--points", 7, "--seconds", 90, "--against", names]
    return charted(tmp_path_factory.mktemp("against"), *words)


def test_another_package_is_measured_as_pkgens_methods_are(found) -> None:
    told, rows, page = found
    beside = [a for a in told["against"] if a["package"].startswith("pip ")]
    of = {m: [r for r in rows if r["method"] == f"known_{m}"] for m in ROW.methods}
    scale = max(abs(math.cos(UNTIL)), 1.0)
    for row in of["good"]:
        assert row["peer"].startswith("pip ") and row["family"] == "other packages"
        exact = abs(math.cos(UNTIL)) * float(row["rtol"]) / scale
        assert float(row["error"]) == pytest.approx(exact, rel=1e-2, abs=1e-14)
        assert row["outcome"] == "done" and row["evaluations"] == row["work"] == "7"
        assert row["steps"] == row["jacobians"] == ""
        took = 1e-4 * -math.log10(float(row["rtol"]))
        assert took <= float(row["seconds"]) < 2 * took
    assert {r["outcome"] for r in of["slow"]} == {"given up"}
    failed = [r for r in of["fails"] if float(r["rtol"]) < 1e-5]
    assert failed and all(
        r["outcome"] == "failed" and r["reason"] == "too small for it" for r in failed
    )
    assert all(r["peer"] == "" for r in rows if r["method"] in ("rk4", "dop853"))
    # Its answers are the loosest tolerances, by its two methods; pkgen's are commands, and its own.
    assert [a["accuracy"] for a in beside] == [1e-3, 1e-6, 1e-9, 1e-12]
    own = {a["accuracy"]: a for a in told["answers"] if a["cheapest_in"] == "seconds"}
    for a in beside:
        assert a["method"] in ("known_good", "known_fails") and a["error"] <= a["accuracy"]
        assert a["rtol"] > 0.2 * a["accuracy"]
        assert a["times"] == pytest.approx(a["seconds"] / own[a["accuracy"]]["seconds"])
    assert all(a["method"] in ("rk4", "dop853") or "gsl" in a["method"] for a in told["answers"])
    if find_spec("pkgen_pages") is None:
        return  # the page is of another add-on
    assert "known_good</text>" in page and "Other packages take, in that order" in page
    assert "<td>known_good</td>" in page and "pkgen run" in page
    assert "<h2>Other packages</h2>" in page and page.count(f"<td>{beside[0]['package']}</td>") == 4


BRIEF = ("--against", "known", "--methods", "rk4", "--points", 5, "--seconds", 3)


def test_errors_on_the_way_are_measured_too(tmp_path: Path) -> None:
    rows = charted(tmp_path, *BRIEF, "--error", "max")[1]
    good = [r for r in rows if r["method"] == "known_good"]
    assert len(good) > 4
    for row in good:  # largest at the start but one, where the cosine is
        exact = math.cos(UNTIL / 100) * float(row["rtol"])
        assert exact - 1e-14 <= float(row["error"]) <= 1.01 * float(row["rtol"]) + 1e-14


def test_starts_are_a_median_of_theirs_too(tmp_path: Path) -> None:
    rows = charted(tmp_path, *BRIEF, "--starts", 3)[1]
    assert all(r["least"] and r["most"] for r in rows if r["method"] == "known_good")


# -- which there are -----------------------------------------------------------------------------


def asked_for(against: str, error: str = "final") -> tuple[Peer, ...]:
    return command.chosen(argparse.Namespace(against=against, error=error)).peers


def test_what_is_missing_is_said_with_how_to_get_it(monkeypatch, capsys) -> None:
    none = replace(ROW, name="none", module="no_such_module", package="nothing")
    monkeypatch.setattr(command, "PEERS", (ROW, none))
    assert asked_for("none, known") == (ROW,)
    said = capsys.readouterr().err
    assert "none cannot be imported" in said and "pip install nothing" in said
    with pytest.raises(UsageError, match="pip install nothing"):
        asked_for("none")
    with pytest.raises(UsageError, match="did you mean 'none'"):
        asked_for("non")
    with pytest.raises(UsageError, match="--error energy"):
        asked_for("known", "energy")
    with pytest.raises(UsageError, match="one package at least"):
        asked_for(" , ")


@pytest.mark.parametrize(
    "body, said",
    [
        ("potential abs(x)\n", "heyoka has no sign"),
        ("potential step(x)*x'^2/2 + x^2\n", "rates jump where x is zero"),
    ],
)
def test_a_model_that_a_package_cannot_have_is_refused(
    body: str, said: str, tmp_path: Path
) -> None:
    path = tmp_path / "kinked.lag"
    path.write_text(f"model kinked\ncoord x\nkinetic x'^2/2\n{body}start x = 1\n")
    motion = motion_of(path)

    def opened(motion: Motion, method: str) -> peers.Integrate:
        motion.expressions("heyoka", object(), 0.0, [0.0, 0.0])
        return invented(motion, method)

    refused = against.attach_peers([replace(ROW, open=opened)], motion.compilation, [])
    if not refused:
        with pytest.raises(peers.Refused, match=said):
            opened(motion, "")
    else:
        assert said in refused["known"]


def test_gsl_is_the_runtimes(found) -> None:
    if not peers.gsl_methods():
        pytest.skip("pkgen is built without GSL")
    told, rows, _ = found
    assert {r["method"] for r in rows if r["family"] == "GSL"} <= set(peers.gsl_methods())
    beside = [a for a in told["against"] if a["package"] == "gsl"]
    assert beside[0]["method"] in peers.gsl_methods()


# -- real ones -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [p.name for p in peers.PEERS if p.module])
def test_a_package_does_as_it_is_told(name: str, found) -> None:
    (row,) = (p for p in peers.PEERS if p.name == name)
    if row.missing:
        pytest.skip(row.missing)
    told, rows, _ = found
    done = [r for r in rows if r["method"].startswith(f"{name}_") and r["outcome"] == "done"]
    assert {r["method"] for r in done} == {m.name for m in row.charted()}
    for m in row.charted():  # tighter is better, down to round-off
        mine = [float(r["error"]) for r in done if r["method"] == m.name]
        assert min(mine) < 1e-3 * mine[0] and min(mine) < 1e-9
    answers = [a for a in told["against"] if a["package"] == row.version]
    assert len(answers) == 4 and answers[0]["method"] and answers[1]["method"]


@pytest.mark.parametrize("name", [p.name for p in peers.PEERS if p.takes == COMPILED])
def test_a_tolerance_is_relative_to_the_size_of_each_number(name: str, tmp_path: Path) -> None:
    """A linear motion of 2^20 times the size is made of the same steps; not so by heyoka, which has
    one tolerance for all numbers together."""
    (row,) = (p for p in peers.PEERS if p.name == name)
    if row.missing:
        pytest.skip(row.missing)
    path = tmp_path / "oscillator.lag"
    path.write_text(MODEL)
    for method in row.methods:
        ends = []
        for size in (1.0, 2.0**20):
            motion = motion_of(path, "--until", UNTIL, "--start", f"x={size}")
            motion.scales = numpy.array([size, size])
            state = row.open(motion, method)(1e-5, ())[-1]
            ends.append([float(x) / size for x in state])
        assert ends[0] == pytest.approx(ends[1], rel=1e-12)
        assert ends[0] != pytest.approx([math.cos(UNTIL), -math.sin(UNTIL)], rel=1e-15)


def test_scipys_errors_are_those_of_a_program_of_ones_own(found) -> None:
    integrate = pytest.importorskip("scipy.integrate")
    points = [r for r in found[1] if r["method"] == "scipy_DOP853" and r["outcome"] == "done"]
    assert len(points) > 4
    for r in points:
        rtol = max(float(r["rtol"]), 3e-14)
        atol = float(r["rtol"]) * numpy.array(found[0]["reference"]["scales"])
        done = integrate.solve_ivp(
            lambda t, y: [y[1], -y[0]], (0, UNTIL), [1, 0], "DOP853", rtol=rtol, atol=atol
        )
        exact = math.cos(UNTIL), -math.sin(UNTIL)
        error = max(abs(a - b) for a, b in zip(done.y[:, -1], exact, strict=True))
        assert float(r["error"]) == pytest.approx(error, rel=0.02, abs=2e-14)
        assert int(r["evaluations"]) == done.nfev or rtol < 1e-12  # rounding decides there
