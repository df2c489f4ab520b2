"""A part of the bench that fails is named and fails the bench; the others are measured."""

import json
import subprocess
import sys

import pytest

from bench import __main__ as bench
from bench import accuracy, builds, derivation, measure
from conftest import ROOT

PARTS = ("_kernels", "_methods", "_ensembles", "_chains", "_long_run", "_derivation")


def broken(why: str) -> builds.Refused:
    return {"pkgen gauss": builds.Broken(why)}


def raises(error: BaseException):
    def part(*_):
        raise error

    return part


@pytest.fixture
def alone(monkeypatch, tmp_path):
    """The bench with parts that have nothing to do, and one of them replaced: its exit code."""

    def run(part: str = "", does=None) -> int:
        seen = []
        for name in PARTS:
            stub = does if name == part else lambda *_, name=name: seen.append(name) or {}
            monkeypatch.setattr(bench, name, stub)
        monkeypatch.setattr(bench, "OUTPUT", tmp_path)
        monkeypatch.setattr(bench, "_save", lambda *_: None)
        monkeypatch.setattr(sys, "argv", ["bench", "--quick"])
        code = bench.main()
        assert len(seen) == len(PARTS) - bool(part)
        return code

    return run


FAILURES = {
    "raises": lambda: raises(AttributeError("no attribute 'kernels'")),
    "ends": lambda: raises(SystemExit("results differ")),
    "refuses": lambda: lambda *_: broken("pkgen refused chain.lag"),
}
SAID = {"raises": "no attribute 'kernels'", "ends": "results differ", "refuses": "chain.lag"}


@pytest.mark.parametrize("how", FAILURES)
@pytest.mark.parametrize("part", PARTS)
def test_a_part_that_fails_fails_the_bench(alone, capsys, part: str, how: str) -> None:
    assert alone(part, FAILURES[how]()) == 1
    last = capsys.readouterr().err.strip().splitlines()[-1]
    title = part.strip("_").replace("_", " ").capitalize()
    assert last.startswith(f"bench: failed: {title}: ") and SAID[how] in last


def test_who_is_not_installed_fails_nothing(alone, capsys) -> None:
    missing = {"numba": builds.Unavailable("numba is not installed")}
    assert alone("_chains", lambda *_: missing) == 0 == alone()
    assert "failed" not in capsys.readouterr().err


def test_own_methods_that_fail_are_broken_and_peers_that_fail_are_not(monkeypatch) -> None:
    def enter(contender, *_):
        if contender.name == "c":
            raise measure.Inapplicable("verlet needs a system that is separable")
        raise measure.Failed("it diverges")

    class Named:
        starts = staticmethod(lambda count: [None])
        name = "any"

    class Who:
        def __init__(self, name, group):
            self.name, self.group = name, group

    monkeypatch.setattr(measure, "_enter", enter)
    effort = measure.Effort(1, 0, 0, 0, ())
    found = measure.compare(
        Named,
        [Who("a", "pkgen"), Who("b", "C"), Who("c", "pkgen")],
        [None],
        effort,
        lambda text: None,
    )
    assert isinstance(found.refused["a"], builds.Broken)
    assert str(found.refused["b"]) == "it diverges"
    assert not isinstance(found.refused["b"], builds.Broken)
    assert not isinstance(found.refused["c"], builds.Broken)
    assert "separable" in str(found.refused["c"])


def test_a_scene_that_cannot_be_judged_fails_the_judgement(monkeypatch, capsys) -> None:
    def judge(case, folder):
        raise RuntimeError("the driver ended with code 2")

    monkeypatch.setattr(accuracy, "judge", judge)
    name = next(case.name for case in accuracy.CASES if case.quick)
    assert accuracy.main(["--quick", "--only", name]) == 1
    assert f"bench: failed: {name}" in capsys.readouterr().err.strip().splitlines()[-1]


def test_what_a_chain_costs_is_measured() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "bench.derivation", "3"], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    (row,) = json.loads(done.stdout.splitlines()[-1])["rows"]
    assert row["n"] == 3 and 20 < row["operations"] < 1000
    assert 0 < row["derive_seconds"] < row["emit_seconds"] and row["gcc_seconds"] > 0


def test_a_derivation_that_fails_says_so(monkeypatch) -> None:
    monkeypatch.setattr(derivation, "pkgen_python", lambda: "/bin/false")
    with pytest.raises(builds.Broken):
        derivation.measure()
