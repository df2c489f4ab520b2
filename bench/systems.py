"""`python -m bench systems [--docs]`: every scene of every model, as `pkgen run --json` tells it.

A row a scene: degrees of freedom, of the model and of what is integrated; the method that ran, the
largest drift of the energy where it is constant, how many expectations were met, of them the one
that came nearest to its bound, and the time of the run. Exit code 4 if one was missed.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from pkgen import __main__ as command
from pkgen.compiler import Compilation, compile_model
from pkgen.front.read import read
from pkgen.run import named
from pkgen.scenes import compile_plan as scene_use
from pkgen.scenes import lengths

from . import machine, tables
from .chosen import chosen

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/dev/results/models.md"
MARK = "<!-- python -m bench systems --docs -->\n"
HEAD = (
    "model",
    "scene",
    "degrees of freedom",
    "method",
    "drift of the energy",
    "met",
    "nearest to its bound",
    "ms",
)


@dataclass(frozen=True)
class Row:
    model: str
    scene: str
    declared: int
    integrated: int
    told: dict  # what `pkgen run --json` says

    @property
    def expects(self) -> list[dict]:
        return self.told["expects"]

    @property
    def met(self) -> int:
        return sum(expected["met"] for expected in self.expects)

    @property
    def method(self) -> str:
        report = self.told["report"]
        first = self.told["settings"]["step"]
        ways = (f"{p['method']} {_setting(p, first)}" for p in report.get("parts") or [report])
        return ", ".join(dict.fromkeys(way.strip() for way in ways))

    @property
    def drift(self) -> str:
        report = self.told["report"]
        found = [d["max"] for d in report.get("drifts", ()) if d["name"] == "energy"]
        # Of a swarm it is what is expected of it.
        found += [e["value"] for e in self.expects if e["text"].startswith("expect drift(energy)")]
        return f"{found[0]:.1e}" if found else "–"

    @property
    def nearest(self) -> str:
        """What was found, of what was allowed, where that is the largest part."""
        parts = [part for expected in self.expects if (part := _part(expected)) is not None]
        if not parts:
            return "–"
        _, value, allowed = max(parts)
        return f"{value:.2g} of {allowed:.2g}"

    def cells(self) -> tuple[str, ...]:
        members = self.told["report"].get("members")
        return (
            self.model,
            self.scene,
            _degrees(self.declared, self.integrated) + (f", {members} times" if members else ""),
            self.method,
            self.drift,
            f"{self.met} of {len(self.expects)}" if self.expects else "–",
            self.nearest,
            f"{1e3 * self.told['report']['seconds']:.2g}",
        )


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench systems", description=__doc__)
    parser.add_argument("--only", default="", help="scenes whose 'model scene' has this text")
    parser.add_argument("--docs", action="store_true", help="write docs/dev/results/models.md")
    arguments = parser.parse_args(words)
    rows = []
    scenes = [
        (path, name)
        for path in sorted((ROOT / "models").rglob("*.lag"), key=_order)
        for name in re.findall(r"^scene (\w+)", path.read_text(encoding="utf-8"), re.M)
    ]
    for path, name in chosen(scenes, arguments.only, lambda scene: f"{scene[0].stem} {scene[1]}"):
        rows.append(row(path, name))
        print(" | ".join(rows[-1].cells()), file=sys.stderr, flush=True)
    met, asked = sum(row.met for row in rows), sum(len(row.expects) for row in rows)
    models = len({row.model for row in rows})
    said = f"Scenes: {len(rows)}, of models: {models}, expectations met: {met} of {asked}"
    text = f"{said}.\n\n{tables.table(HEAD, (row.cells() for row in rows))}\n"
    print(text)
    if arguments.docs:
        if arguments.only:
            raise SystemExit("bench systems: --docs wants all scenes")
        before, _, _ = PAGE.read_text(encoding="utf-8").partition(MARK)
        here = "; ".join(machine.describe().lines())
        PAGE.write_text(f"{before}{MARK}\n{here}\n\n{text}", encoding="utf-8")
    return 0 if met == asked else 4


def _order(path: Path) -> tuple[str, str]:
    """Folder by folder, those of models/ itself first."""
    inside = path.relative_to(ROOT / "models")
    return (str(inside.parent).removeprefix("."), path.stem)


def row(path: Path, name: str) -> Row:
    parsed = command.parser_of("run").parse_args([str(path), "--scene", name])
    compilation = compile_model(
        read(str(path)), unroll=lengths.UNROLL, use=scene_use.of_run(parsed)
    )
    with tempfile.TemporaryDirectory() as directory:
        words = ["run", path, "--scene", name, "-o", Path(directory, "rows.csv"), "--json"]
        done = subprocess.run(
            [sys.executable, "-m", "pkgen", *words], capture_output=True, text=True
        )
    if done.returncode not in (0, 4):
        raise SystemExit(f"bench systems: {path} {name}: {done.stderr}")
    return Row(
        path.stem,
        name,
        *_freedom(compilation),
        json.loads(done.stdout),
    )


def _freedom(compilation: Compilation) -> tuple[int, int]:
    """Of the model and of what is left of it: coordinates, states and three for a rotation, less
    the rows of constraints and of rolling that always hold."""
    model, e = compilation.declared, compilation.equations
    declared = named.declared(compilation).count - len(model.rotations) - len(model.constraints)
    declared += sum(len(mode.constraints) for mode in model.modes)
    declared -= sum(state.name.startswith("loss(") for state in model.states)
    if not compilation.equations.dense:
        return declared, named.coordinates(compilation).count
    quaternions = sum(4 for a in e.attitudes if a.state >= 0)
    rows = len(e.constraints.names) - len(e.constraints.meetings) if e.constraints else 0
    losses = sum(q.name.startswith("loss(") for q in e.states)
    return declared, len(e.coordinates) - rows + len(e.states) - quaternions - losses


def _setting(report: dict, first: float | None) -> str:
    """The step, of a variable one the first, or the tolerance; the exponential has neither."""
    if report["method"] == "exponential":
        return ""
    if report.get("step") is not None:
        return f"h = {report['step']:.3g}"
    if first is not None:
        return f"h from {first:.3g}"
    return f"{report['rtol']:.0e}" if "rtol" in report else ""


def _part(expected: dict) -> tuple[float, float, float] | None:
    """Of a value within a bound and of a drift: what it is of what is allowed, it, and that."""
    a, b, within = (expected[key] for key in ("value", "bound", "within"))
    if a is None or b is None:
        return None
    if within is not None:
        figure, allowed = abs(a - b), within
    elif expected["text"].startswith("expect drift("):
        figure, allowed = a, b
    else:
        return None
    return (figure / allowed if allowed else math.inf, figure, allowed)


def _degrees(declared: int, integrated: int) -> str:
    return str(declared) if declared == integrated else f"{declared} → {integrated}"
