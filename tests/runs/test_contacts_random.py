"""Random models with contacts, impacts, friction, values after events and samples: motions against
tests/contact_reference.py, which stops SciPy at each event."""

import math
import random
from pathlib import Path

import numpy as np
import pytest
from contact_drafts import Draft
from contact_kinds import body, drafted, pendulums, points, sliders
from contact_mechanics import System
from contact_reference import Motion, softened

import pkgen
from conftest import long_but

UNTIL, EVERY = 3.0, 0.05


def names_of(s: System) -> list[str]:
    if s.mass:
        return ["x", "y", "z", "x'", "y'", "z'"]
    return [*s.coordinates, *(f"{q}'" for q in s.coordinates)]


def compared(seed: int, folder: Path) -> dict:
    """Compares a drawn model; returns what happened."""
    text, d, system = drafted(seed, folder)
    (folder / "m.lag").write_text(text)
    motion = Motion(system)
    times = np.linspace(0, UNTIL, round(UNTIL / EVERY) + 1)
    rows, end, why, log = motion.run(d.own, UNTIL, times)
    lost = list(motion.lost)
    found = {
        "end": end,
        "why": why,
        "log": log,
        "text": text,
        "error": "",
        "worst": 0.0,
        "lost": 0.0,
        "each": 0.0,
        "tolerance": 1.0,
        "hits": [],
        "wanted": [],
    }
    until = end if not why else end - 1e-5
    if until <= EVERY:
        return found
    method = d.draw.choice((None, "gauss", "gauss", "dop853", "dop853", "radau", "rk4"))
    accuracy = {"step": 1e-3} if method == "rk4" else {"rtol": 1e-12}
    m = pkgen.load(str(folder / "m.lag"))
    run = m.run(until=until, every=EVERY, method=method, max_steps=20000, **accuracy)
    names = names_of(system)
    pick = range(len(d.own)) if not system.mass else [0, 1, 2, 7, 8, 9]
    worst, first, tolerance = 0.0, None, 1e-6 if method == "rk4" else 1e-8
    for i, state in rows:
        if times[i] > until or i >= len(run.t):
            continue
        off = max(abs(run[n][i] - state[k]) for n, k in zip(names, pick, strict=True))
        off /= max(1.0, abs(state).max())
        if not off <= worst:
            worst = off
        if not off <= tolerance and first is None:
            first = float(times[i])
    found |= {
        "worst": worst,
        "first": first,
        "method": method,
        "rows": len(rows),
        "tolerance": tolerance,
    }
    if not why:
        mine = [x["lost"] for x in run.report["contacts"] if x["name"].startswith("c")][: len(lost)]
        counts = [sum(x[1:] == ("hits", k) for x in log) for k in range(len(lost))]
        found["wanted"], found["hits"] = (
            counts,
            [len(run.events[f"c{k}"]) for k in range(len(lost))],
        )
        found["lost"] = abs(sum(mine) - sum(lost)) / max(1.0, sum(map(abs, lost)))
        each = max(abs(a - b) for a, b in zip(mine, lost, strict=True))
        found["each"] = each / max(1.0, sum(map(abs, lost)))
    return found


QUICK = range(3)
CHUNKS = [QUICK, *(range(k, k + 25) for k in range(3, 528, 25))]


@pytest.mark.filterwarnings("ignore:.*never used")
@pytest.mark.parametrize("seeds", long_but([QUICK], CHUNKS), ids=lambda x: f"{x[0]}-{x[-1]}")
def test_motions_are_those_of_scipy_stopped_at_each_event(seeds: range, tmp_path: Path) -> None:
    for seed in seeds:
        (folder := tmp_path / str(seed)).mkdir()
        found = compared(seed, folder)
        most = max(found["worst"], found["lost"], found["each"])
        assert most <= found["tolerance"], (seed, found)
        assert found["hits"] == found["wanted"], (seed, found)


# models that meet something, and in which all is determined
SOFT = (2, 4, 5, 6, 8, 9, 10, 14, 16, 24, 25, 28, 30, 32, 34, 35, 36, 45, 47, 48)


@pytest.mark.filterwarnings("ignore:.*never used")
@pytest.mark.parametrize("seed", long_but([32], SOFT))
def test_motions_are_limits_of_stiff_smooth_ones(seed: int, tmp_path: Path) -> None:
    draw = random.Random(seed)
    d = Draft(draw, plain=True)
    draw.choice((points, pendulums, body, sliders))(d)
    names = d.system.coordinates
    start = [d.start[n + end] for end in ("", "'") for n in names]
    (tmp_path / "m.lag").write_text(d.text())
    run = pkgen.load(str(tmp_path / "m.lag")).run(until=1.2, every=0.1, rtol=1e-10)
    mine = np.array([run[n] for n in names]).T
    motion, errors = Motion(d.done()), []
    for eps in (8e-3, 2e-3, 5e-4):
        states = softened(motion, eps, start, run.t)
        errors.append(abs(states[:, : len(names)] - mine).max())
    assert errors[0] > 2.4 * errors[1] > 2.4**2 * errors[2], errors
    assert errors[2] < 0.03, errors


def ran(folder: Path, text: str, until: float, method: str, **options):
    (folder / "m.lag").write_text(f"model m\n{text}\n")
    return pkgen.load(str(folder / "m.lag")).run(
        until=until, method=method, rtol=1e-12, max_steps=1000, **options
    )


METHODS = pytest.mark.parametrize("method", ["gauss", "dop853"])


@METHODS
def test_an_event_that_turns_the_motion_back_is_met_once(method: str, tmp_path: Path) -> None:
    text = "coord x\nkinetic x'^2/2\nevent a: x - 1 then x' = -0.8*x'\n"
    r = ran(tmp_path, text + "event b: x + 1 then x' = -0.8*x'\nstart x' = 1", 10, method, every=1)
    assert r.events["a"] == pytest.approx([1, 6.625]) and r.events["b"] == pytest.approx([3.5])
    assert r["x"][-1] == pytest.approx(1 - 0.512 * 3.375, abs=1e-12)


@METHODS
def test_a_gap_opens_from_rest_where_all_is_zero(method: str, tmp_path: Path) -> None:
    text = "coord y\nkinetic y'^2/2\npotential 9.81*y\ncontact c: 0 >= y"
    assert ran(tmp_path, text, 2, method, every=2)["y"][-1] == pytest.approx(-19.62, rel=1e-10)


@METHODS
@pytest.mark.parametrize("x", [-0.019, 0.45, 0.5])
def test_what_sticks_from_the_start_stays(x: float, method: str, tmp_path: Path) -> None:
    text = f"""coord x
kinetic 0.414*x'^2/2
potential 0.49*(x + 0.429)^2/2
force x = 1.204*sin(0.533*t)
contact c: x + 3 >= 0
friction x = 1.18 static 1.626
start x = {x}"""
    assert ran(tmp_path, text, 3, method, every=3)["x"][-1] == pytest.approx(x, abs=1e-12)


def test_a_body_that_an_event_lifts_is_not_put_back(tmp_path: Path) -> None:
    text = "coord y\nkinetic y'^2/2\npotential y\ncontact c: y >= 0\n"
    r = ran(tmp_path, text + "event e: 1 - t falling then y = y + 2", 2, "gauss", every=1)
    assert r["y"][-1] == pytest.approx(1.5, abs=1e-12)


def test_a_gap_may_be_the_least_of_several(tmp_path: Path) -> None:
    text = """coord x, y
kinetic (x'^2 + y'^2)/2
potential 9.81*y
contact c: min(y + x, y - x) >= 0 restitution 0.9
start y = 1, x = 0.1, x' = 0.2"""
    r = ran(tmp_path, text, 3, "gauss", every=0.01)
    assert (r["y"] - abs(r["x"])).min() > -1e-12 and len(r.events["c"]) == 8


ON_X = "coord x\nkinetic x'^2/2\n"
ON_FLOOR = "coord x, y\nkinetic (x'^2 + y'^2)/2\npotential 10*y\n"
COUNTS = f"{ON_X}sample block every 1\n  memory c = 0\n  set c = c + 1\nend\n"
LATCHED = """constraint h: x + 0.3 = 0
event meets: x + 0.3 falling
event tired: 0.5 - t falling
mode latch: constraint h on at meets off at tired
start x' = -1, x = -0.2"""


@pytest.mark.parametrize(
    ("text", "until", "x"),
    [
        (f"{ON_FLOOR}contact f: y - max(0, x - 1) >= 0\nstart x' = 5", 1, 1.4),
        (f"{ON_FLOOR}contact f: y - min(0, 1 - x) >= 0\nstart x' = 1", 2, 4),
        (f"{ON_FLOOR}contact f: y - min(0, -x) >= 0\nstart x' = -1", 1, -1),
        (f"{ON_FLOOR}contact f: y - max(0, x) >= 0\nstart x' = 1", 0.5, -0.15),
        (f"{ON_X}potential 10*x\ncontact f: x - max(0, t - 1) >= 0", 2, 1),
        (f"{ON_X}let s = x' - if(t > 1, 1, 0)\nfriction s = 1", 2, 0.5),
        (f"{ON_X}let s = x' - if(t > 1, 2, -1)\nfriction s = 1\nstart x' = 2", 2, 3),
        (f"{ON_X}let s = x' - t + 1\nfriction x = 0.5\nfriction s = 2\nstart x' = -1", 2, 0),
        (f"{ON_X}friction x = cos(t)\nstart x' = 3", 4, 7 + math.pi / 2),
        (f"{ON_FLOOR}contact f: y >= 0 friction cos(t)/10\nstart x' = 3", 4, 7 + math.pi / 2),
        (f"{COUNTS}contact f: x >= 0\npotential 10*x\nforce x = 8*c", 2, 3),
        (f"{COUNTS}event e: c - 1.5 rising then x' = -2\nforce x = 0*c\nstart x' = 1", 3, -3),
        (f"{ON_X}potential 2*(x - 0.3)^2\n{LATCHED}", 1.5, 0.3 - 0.6 * math.cos(2)),
    ],
    ids=str.split(
        "bends_up bends_down begins_on_a_roof begins_in_a_valley wall_starts belt_starts belt_turns"
        " two_frictions_part bound_below_0 mu_below_0 sample_opens"
        " sample_gives_values latch_at_rest"
    ),
)
def test_what_changes_at_once(text: str, until: float, x: float, tmp_path: Path) -> None:
    """At kinks and jumps of gaps, slips and bounds, at samples, and where a latch lets go."""
    found = ran(tmp_path, text, until, "radau", every=until)["x"][-1]
    assert found == pytest.approx(x, abs=1e-9)


def test_friction_is_of_the_force_whatever_the_scale_of_the_gap(tmp_path: Path) -> None:
    a = math.atan(0.5)
    text = "coord x, y\nkinetic (x'^2 + y'^2)/2\npotential 10*y\n"
    text += "contact c: 7*(y + x/2) >= 0 friction 0.2"
    r = ran(tmp_path, text, 1, "gauss", every=1)
    along = 10 * (math.sin(a) - 0.2 * math.cos(a)) / 2
    assert math.hypot(r["x"][-1], r["y"][-1]) == pytest.approx(along, rel=1e-10)


@pytest.mark.parametrize("contact", ["", "contact c: x + 9 >= 0\n"])
def test_a_value_that_breaks_a_constraint_ends_the_run(contact: str, tmp_path: Path) -> None:
    text = "coord x, y\nkinetic (x'^2 + y'^2)/2\nconstraint h: y = x\n"
    with pytest.raises(Exception, match="breaks a constraint: h by"):
        ran(tmp_path, f"{text}{contact}event e: t - 1 then y = y + 1", 2, "gauss", every=1)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("restitution e", "the restitution of c is 2: it is from 0 to 1"),
        ("friction -e along x'", "is -2: it is at least 0"),
    ],
)
def test_numbers_of_parameters_are_judged_by_the_run(line: str, words: str, tmp_path) -> None:
    text = "param e = 2\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential y\n"
    with pytest.raises(Exception, match=words):
        ran(tmp_path, f"{text}contact c: y >= 0 {line}\nstart y = 1", 2, "gauss", every=1)
