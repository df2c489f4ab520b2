"""`python -m bench member_lanes [--docs]`: members whose steps are made in lanes, beside the same
members one by one, by a runtime that is compiled without (-DPK_ONE_BY_ONE).

Both take turns, on one thread; seconds are the processor's, a figure is the median of the ratios of
each turn. Exit code 4 if a row differs.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from . import tables
from .report import write_table
from .systems import ROOT

PAGE = ROOT / "docs" / "commands.md"
HEAD = ("members", "method", "one by one", "in lanes", "ratio")
MEMBERS, TURNS = 500, 3

PENDULUM = (ROOT / "models/double_pendulum.lag").read_text(encoding="utf-8")
SWING = {of: (-1.5, 1.5) for of in ("theta1", "theta2", "theta1'", "theta2'")}
WATCHED = PENDULUM + "event low: theta2 rising\nevent flip: theta2 - 3 rising stop\n"
HENON_HEILES = """model henon_heiles
coord x, y
kinetic (x'^2 + y'^2)/2
potential (x^2 + y^2)/2 + x^2*y - y^3/3
event section: x rising
"""
BALL = """model ball
param k = 1000 in (0, inf)
coord x
kinetic x'^2/2
potential 9.81*x + k/2*step(-x)*x^2
"""
STAIRS = """model stairs
coord x
kinetic x'^2/2
potential 0.3*step(x - 1) + x^2/2
event middle: x - 0.5
"""
STEP = ("--step", "0.01")
LOOSE = ("--rtol", "1e-9")


@dataclass(frozen=True)
class Case:
    members: str
    text: str
    ranges: dict[str, tuple[float, float]]
    until: float
    words: tuple[str, ...]


CASES = (
    Case("events", WATCHED, SWING, 10, ("rk4", *STEP, "--at", "low")),
    Case(
        "a section",
        HENON_HEILES,
        {"x": (-0.4, 0.4), "y'": (-0.3, 0.3)},
        50,
        ("yoshida4", "--step", "0.05", "--at", "section"),
    ),
    Case("a switch", BALL, {"x": (0.5, 1.5)}, 10, ("rk4", *STEP)),
    Case("impulses", STAIRS, {"x'": (0.5, 2)}, 20, ("rk4", *STEP, "--at", "middle")),
    Case("adaptive", PENDULUM, SWING, 10, ("dop853", *LOOSE)),
    Case("adaptive", PENDULUM, SWING, 10, ("dopri5", "--rtol", "1e-6")),
    Case("adaptive, rows", PENDULUM, SWING, 10, ("dop853", *LOOSE, "--every", "0.1")),
    Case("adaptive, events", WATCHED, SWING, 10, ("dop853", *LOOSE, "--at", "low")),
    Case("adaptive, a switch", BALL, {"x": (0.5, 1.5)}, 10, ("dop853", *LOOSE)),
)


def ran(case: Case, folder: Path, alone: bool) -> tuple[float, bytes]:
    """Seconds of the processor, and the rows."""
    out = folder / "rows.csv"
    words = ["--method", *case.words, "--until", case.until, "--threads", 1, "-o", out]
    if "--at" not in words and "--every" not in words:
        words += ["--every", case.until]
    command = [sys.executable, "-m", "pkgen", "run", folder / "model.lag"]
    command += ["--ensemble", folder / "members.csv", *words]
    env = {**os.environ, "CFLAGS": "-DPK_ONE_BY_ONE"} if alone else None
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, env=env)
    if done.returncode:
        raise SystemExit(f"bench: {case.members}: {done.stderr}")
    report = json.loads(Path(f"{out}.json").read_text(encoding="utf-8"))["report"]
    return report["processor"], out.read_bytes()


def measured(case: Case) -> tuple[bool, tuple[str, ...]]:
    """Whether rows are the same; the row of the table."""
    random.seed(case.members)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "model.lag").write_text(case.text, encoding="utf-8")
        lines = [",".join(case.ranges)]
        for _ in range(MEMBERS):
            lines.append(",".join(repr(random.uniform(*span)) for span in case.ranges.values()))
        (folder / "members.csv").write_text("\n".join(lines) + "\n")
        turns = [(ran(case, folder, True), ran(case, folder, False)) for _ in range(TURNS)]
    same = all(alone[1] == lanes[1] for alone, lanes in turns)
    one, other = (statistics.median(turn[k][0] for turn in turns) for k in (0, 1))
    ratio = statistics.median(alone[0] / lanes[0] for alone, lanes in turns)
    return same, (case.members, case.words[0], f"{one:.3g}", f"{other:.3g}", f"{ratio:.2g}×")


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench member_lanes", description=__doc__)
    parser.add_argument("--docs", action="store_true")
    options = parser.parse_args(arguments)
    found = []
    for case in CASES:
        found.append(measured(case))
        print(" | ".join(found[-1][1]), flush=True)
    text = tables.table(HEAD, [row for _, row in found])
    print(text)
    if options.docs:
        write_table(PAGE, "member_lanes", text)
    return 0 if all(same for same, _ in found) else 4
