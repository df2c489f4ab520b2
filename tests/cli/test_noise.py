"""Noise in runs, ensembles, programs and in Python: seeds, the same bits, what refuses it."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

import pkgen
from conftest import ran, run_pkgen
from pkgen.methods import METHODS

TEXT = """model drifting
param m = 1 [kg]
param S = 0.5 [N^2*s]
param c = 0.2 [kg/s]
coord x, y [m]
let P = [x, y, 0]
kinetic m/2*dot(P', P')
potential (1 [N/m])/2*dot(P, P)
dissipation c/2*x'^2
noise x = S*(1 + (x/(1 [m]))^2)
noise P = [0, S, S]
event level: x rising
event far: x - 3 [m] rising stop
start x = 1
"""
BAOAB = ("--method", "baoab", "--step", "0.1", "--until", "5")
OTHERS = pytest.mark.needs_addon
NOISY = ("baoab", "heun", "stochastic_verlet")


def out(*arguments: object) -> str:
    return ran(*arguments).stdout


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "drifting.lag"
    path.write_text(TEXT, encoding="utf-8")
    return path


def test_a_seed_is_reported_and_repeats_a_run(model: Path) -> None:
    first = json.loads(out("run", model, *BAOAB, "--seed", 2**64 - 1, "--json"))
    again = json.loads(out("run", model, *BAOAB, "--seed", 2**64 - 1, "--json"))
    other = json.loads(out("run", model, *BAOAB, "--json"))
    assert first["report"]["seed"] == 2**64 - 1 and other["report"]["seed"] == 0
    assert first["rows"] == again["rows"] != other["rows"]
    loaded = pkgen.load(model)
    r = loaded.run(5, method="baoab", step=0.1, seed=2**64 - 1)
    assert r["x"][-1] == first["rows"][-1][1] and r.report["seed"] == 2**64 - 1


@pytest.mark.parametrize("method", NOISY)
@pytest.mark.parametrize("events", [True, False])
def test_members_are_the_same_for_any_threads_and_shards(
    tmp_path: Path, method: str, events: bool
) -> None:
    text = TEXT if events else TEXT.partition("event")[0] + "start x = 1\n"
    each = []
    for k, (threads, ends) in enumerate(((1, "1..40"), (2, "1..40"), (2, "21..40"))):
        path = tmp_path / f"m{k}.lag"
        scene = f"scene s\n  swarm k = {ends}\n  start x = k/k*(1 [m])\n  until 3 [s]\n"
        scene += f"  method {method} step 0.1 [s]\n  record x, y every 1 [s]\nend\n"
        path.write_text(text + scene, encoding="utf-8")
        each.append(out("run", path, "--scene", "s", "--threads", str(threads)).splitlines())
    assert each[0] == each[1]
    assert each[2][1:] == each[0][1 + len(each[0]) - len(each[2]) :]
    assert len({line.partition(",")[2] for line in each[0]}) > 80


PLAN = """until = 2
method = "baoab"
step = 0.1
members = 12
seed = {}
keep = ["final"]
[random]
x = "0.99 .. 1 [m]"
"""


@pytest.mark.needs_addon
def test_a_sweep_has_the_seed_of_its_plan_in_any_shards(model: Path, tmp_path: Path) -> None:
    sets = []
    for seed, shard in ((3, 12), (3, 5), (4, 5)):
        plan, made = tmp_path / "plan.toml", tmp_path / f"made{seed}{shard}"
        plan.write_text(PLAN.format(seed))
        ran("sweep", model, "--plan", plan, "--shard", shard, "-o", made)
        sets.append((made / "data" / "part-000000.parquet").read_bytes())
    assert sets[0] == sets[1] != sets[2]


def test_a_program_has_the_seed_too(model: Path, tmp_path: Path) -> None:
    made = tmp_path / "program"
    ran("build", model, "-o", made)
    for seed in ("7", "0"):
        how = (*BAOAB, "--every", "0.15", "--seed", seed)
        rows = subprocess.run([made, *how], capture_output=True, text=True, check=True)
        assert rows.stdout == out("run", model, *how)
    assert subprocess.run([made, "--seed", "x"], check=False).returncode == 2


@pytest.mark.parametrize("method", NOISY)
def test_step_by_step(model: Path, method: str) -> None:
    it = pkgen.load(model).integrator(method, step=0.1, seed=5)
    it.to(1.0)
    whole = pkgen.load(model).run(2, method=method, step=0.1, seed=5)
    it.to(2.0)
    assert it.q[0] == whole["x"][-1]


def test_events_are_met(model: Path) -> None:
    r = pkgen.load(model).run(200, method="heun", step=0.05, seed=1, at="level")
    assert len(r.t) > 3 and np.abs(r["x"]).max() < 1e-9
    end = pkgen.load(model).run(2000, method="baoab", step=0.05, seed=2)
    assert end.t[-1] < 2000 and end["x"][-1] == pytest.approx(3, abs=1e-9)


@pytest.mark.parametrize("method", sorted(METHODS))
def test_methods_without_noise_refuse_it_by_name(model: Path, method: str) -> None:
    how = () if "adaptive" in METHODS[method].traits else ("--step", "0.1")
    done = run_pkgen("run", model, "--method", method, *how, "--until", "1")
    assert (done.returncode == 0) == (method in NOISY), done.stderr
    assert method in NOISY or method in done.stderr


@pytest.mark.parametrize(
    "arguments, says",
    [
        (("run", "--step=0.1", "--set=S=-1"), "the intensity of the noise on x is -1.99501"),
        (("run", "--step=0.1", "--seed=-1"), "from 0 to 2^64 - 1"),
        pytest.param(("run", "--enclose"), "--enclose knows", marks=OTHERS),
        (("run", *BAOAB, "--diagnose=lyapunov"), "--diagnose knows no noise"),
        (("chart",), "noise has no reference"),
        (("stability",), "pkgen stability knows no noise"),
        pytest.param(("export", "--as", "fmu"), "pkgen export knows no noise", marks=OTHERS),
    ],
)
def test_what_refuses_noise_says_so(model: Path, arguments: tuple, says: str) -> None:
    done = run_pkgen(arguments[0], model, *arguments[1:])
    assert done.returncode and says in done.stderr


def test_accuracy_and_constraints_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "m.lag"
    for more, says in (
        ("scene s\nuntil 1\naccuracy 1e-6\nrecord x\nend\n", "noise has none"),
        ("constraint rod: x^2 + y^2 = 1 [m^2]\n", "a noise acts on what constraints hold"),
        ("contact floor: y >= 0\n", "a noise acts on what constraints hold"),
    ):
        path.write_text(TEXT + more, encoding="utf-8")
        done = run_pkgen("run", path, *(("--scene", "s") if "scene" in more else BAOAB))
        assert done.returncode and says in done.stderr


def test_where_a_method_does_not_fit_it_says_what_it_needs(tmp_path: Path) -> None:
    path = tmp_path / "m.lag"
    path.write_text(TEXT.replace("c/2*x'^2", "c/2*x'^2*(1 + x^2/(1 [m^2]))"), encoding="utf-8")
    for method in ("baoab", "stochastic_verlet"):
        done = run_pkgen("run", path, *BAOAB, "--method", method)
        assert done.returncode and f"{method} needs a system that is separable" in done.stderr
    ran("run", path, "--step", "0.1", "--until", "1")  # by heun


def test_a_scene_without_intensity_runs_by_any_method(model: Path) -> None:
    text = TEXT + "scene s\nset S = 0\nuntil 1\nmethod gauss rtol 1e-9\nrecord x\nend\n"
    model.write_text(text, encoding="utf-8")
    ran("run", model, "--scene", "s")


def test_nothing_that_noise_moves_is_reduced(model: Path) -> None:
    scene = "scene s\nuntil 5\nmethod heun step 0.1\nrecord y, y' every 1\nend\n"
    model.write_text(TEXT.partition("event")[0] + scene, encoding="utf-8")
    rows = out("run", model, "--scene", "s")
    assert rows == out("run", model, "--scene", "s", "--no-reduce") != ""


def test_the_word_is_a_name_elsewhere(tmp_path: Path) -> None:
    path = tmp_path / "m.lag"
    text = "model m\nparam noise = 2\ncoord x\nkinetic x'^2/2\npotential noise\n  *x^2/2\n"
    path.write_text(text.replace("\n  ", ""), encoding="utf-8")
    assert pkgen.load(path).params["noise"] == 2
