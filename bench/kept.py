"""`python -m bench kept [--quick] [--only TEXT] [--json FILE] [--docs]`: is what scenes promise by
`accuracy` kept, over hundreds of them?

Each scene of kept_cases.py is run by `pkgen run`, and its rows are compared with those of
kept_reference.py: more digits, another method, nothing reduced. A scene that is warned of is kept
where it holds to the time that is named and none of several methods keeps it; one whose column
is left out without need is not kept. Of every so many the cheapest of all methods is looked for
(accuracy_chart.py), and timed in turns with what was chosen.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import math
import random
import statistics
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy

from pkgen.__main__ import main as command
from pkgen.analysis.chart.chart import methods
from pkgen.analysis.choose.search import TIGHTEST
from pkgen.analysis.choose.trials import Trials
from pkgen.run import named
from pkgen.run.build import build_library
from pkgen.run.named import columns
from pkgen.source import ModelError
from pkgen.system.exits import NumericsFailed, UsageError

from . import kept_reference as reference
from . import machine
from .accuracy import RATIO
from .accuracy_chart import Chart, Way
from .builds import OUTPUT
from .chosen import chosen
from .kept_cases import ROOT, Case, cases
from .tables import table

FOLDER = OUTPUT.parent / "kept"
PAGE = ROOT / "docs/dev/results/accuracy.md"
MARKS = "<!-- python -m bench kept --docs -->\n", "<!-- kept -->\n"
GOAL = 0.98
SAMPLED = 12  # of so many scenes one is charted
ELSEWHERE, MOVED = 0.1, 12  # of a start's magnitude; coordinates that start elsewhere
USUAL = ["gauss", "dop853", "gauss8", "blanes_moan6", "kahan_li8", "radau"]  # where one is sought
KEPT, MISSED, LIMIT, ENDS, UNKNOWN = "kept", "missed", "no method keeps it", "ends", "not judged"


@dataclass(frozen=True)
class Judged:
    """`reached` up to the horizon, where one was warned of; `ratio` of the cost to the cheapest's,
    not a number where that was not looked for."""

    name: str
    kind: str
    verdict: str
    asked: float
    why: str = ""
    reached: float = math.nan
    chosen: str = ""
    horizon: float | None = None
    reference: str = ""
    error: float = math.nan  # of the reference
    cheapest: str = ""
    ratio: float = math.nan
    seconds: float = 0.0

    @property
    def promised(self) -> bool:
        return self.verdict in (KEPT, MISSED, LIMIT)


def judge(case: Case, charted: bool) -> Judged:
    began = time.monotonic()
    FOLDER.mkdir(parents=True, exist_ok=True)
    path = FOLDER / f"{case.name.replace(' ', '_')}.lag"
    path.write_text(case.text, encoding="utf-8")
    asked = float(case.text.rpartition("\n  accuracy ")[2].split()[0])
    try:
        options = _elsewhere(case, path) if case.varied else ()
        found = _judged(case, str(path), options, charted)
    except (RuntimeError, ModelError, NumericsFailed, UsageError) as error:
        found = Judged(case.name, case.kind, UNKNOWN, asked, " ".join(str(error).split())[:200])
    return replace(found, asked=asked, seconds=time.monotonic() - began)


def _elsewhere(case: Case, path: Path) -> tuple[str, ...]:
    """Options that move each start that is not 0 by a tenth of it."""
    one = reference.scene_of(str(path), case.scene, "--no-reduce")
    start = Trials(_program(one), one.settings).start["q"]
    draw = random.Random(f"{case.name} {case.varied}")
    names = [q.name for q in named.coordinates(one.compilation).columns(sys.maxsize)][:MOVED]
    moved = {
        n: x * (1 + draw.uniform(-1, 1) * ELSEWHERE)
        for n, x in zip(names, start, strict=False)
        if x
    }
    return tuple(f"--start={name}={x!r}" for name, x in moved.items())


def _program(one: reference.Scene, *methods: str) -> Path:
    return build_library(one.compilation.files, one.compilation.model.name, *methods)


def _judged(case: Case, path: str, options: Sequence[str], charted: bool) -> Judged:
    out = io.StringIO()
    rows = Path(path).with_suffix(".csv")
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()) as err:
        words = ["run", path, "--scene", case.scene, "--json", "-o", str(rows), *options]
        code = command(words)
    found = Judged(case.name, case.kind, UNKNOWN, 0.0)
    if code not in (0, 4):
        return replace(found, why=(err.getvalue() or out.getvalue()).strip()[-200:])
    if code == 4:
        return replace(found, verdict=ENDS, why=err.getvalue().strip().splitlines()[-1][-200:])
    said = json.loads(out.getvalue())["accuracy"]
    every = said.get("parts", [said])
    made = [[float(x or "nan") for x in line.split(",")] for line in rows.read_text().split()[1:]]
    horizon = min((s["horizon"] for s in every if s["horizon"] is not None), default=None)
    asked = every[0]["asked"]
    known = reference.find(path, case.scene, options, every[0]["method"], asked, horizon)
    off = known.off(made, horizon)
    one = reference.scene_of(path, case.scene, *options)
    names = [c.name for c in one.settings.show or columns(one.compilation)[1:]]
    left = {name for s in every for name in s["reference"]["left_out"]}
    counted = [x for x, skip in zip(off[:-1], known.nothing, strict=True) if not skip]
    found = replace(
        found,
        verdict=KEPT,
        reached=float(max([*counted, off[-1]])),
        chosen=", ".join(f"{s['method']} {s.get('step') or s.get('rtol'):.2g}" for s in every),
        horizon=horizon,
        reference=known.method,
        error=known.error,
    )
    if found.reached > asked:
        return replace(found, verdict=MISSED, why=f"{found.reached:.1e} of {asked:.0e}")
    needless = [n for n, skip in zip(names, known.nothing, strict=False) if n in left and not skip]
    if needless:
        return replace(found, verdict=MISSED, why=f"left out without need: {', '.join(needless)}")
    if any(s["unverified_from"] is not None for s in every):
        return replace(found, why="only a part of it was tried, as is said")
    if horizon is not None and known.to_the_end > reference.ENOUGH * asked:
        return replace(found, verdict=LIMIT, why="nor is it known in more digits")
    if (charted or horizon is not None) and len(every) == 1:
        own, best = _charted(path, case.scene, options, known, said)
        if best is not None:
            ratio = own.seconds / best.seconds
            found = replace(found, cheapest=_way(best), ratio=ratio)
        if horizon is not None and best is None:
            found = replace(found, verdict=LIMIT, why=f"holds until t = {horizon:.4g}")
        elif horizon is not None:
            why = f"warned from t = {horizon:.4g}, but {_way(best)} keeps it"
            found = replace(found, verdict=MISSED, why=why, ratio=math.nan)
    return found


def _charted(
    path: str, name: str, options: Sequence[str], known: reference.Known, said: dict
) -> tuple[Way, Way | None]:
    """What was chosen and the cheapest of all methods that keeps the accuracy as well."""
    one = reference.scene_of(path, name, *options)
    able = methods(None if said["horizon"] is None else USUAL)
    trials = Trials(_program(one, *(m.name for m in able)), one.settings)
    trials.exact = replace(known.rows, between=known.scales)
    for column in numpy.flatnonzero(known.nothing):
        trials.ignore(int(column))
    every = one.settings.every or one.settings.until
    chart = Chart(trials, said["asked"], one.settings.until, every, said["run_seconds"])
    ways = [way for way in chart.ways(able) if _by_right(trials, way, said["asked"])]
    setting = said.get("step") or said.get("rtol")
    own, *near = chart.timed([Way(said["method"], said["rows"], setting, 0.0, 0.0), *ways[:3]])
    return own, min(near, key=lambda w: w.seconds, default=None)


def _by_right(trials: Trials, way: Way, accuracy: float) -> bool:
    """Not by luck alone: a tighter run keeps it too."""
    until = trials.settings.until
    for tighter in (0.8, 0.3):
        setting = max(tighter * way.setting, TIGHTEST)
        if not trials.attempt(way.method, setting, way.rows, until).error <= accuracy:
            return False
    return True


def _way(way: Way) -> str:
    return f"{way.method} {way.rows} {way.setting:.2g}"


HEAD = (
    "scenes", "in all", "kept", "missed", "no method", "ends", "not judged", "asked/reached",
    "charted", "within 1.5", "worst",
)  # fmt: skip


def summary(found: list[Judged]) -> str:
    """A line for each kind of scene, and one for all."""
    kinds = list(dict.fromkeys(j.kind for j in found))
    rows = [_line(kind, [j for j in found if j.kind == kind]) for kind in kinds]
    return table(HEAD, [*rows, _line("all", found)])


def _line(kind: str, found: list[Judged]) -> tuple[str, ...]:
    counts = [sum(j.verdict == v for j in found) for v in (KEPT, MISSED, LIMIT, ENDS, UNKNOWN)]
    over = [j.asked / j.reached for j in found if j.verdict == KEPT and j.reached > 0]
    ratios = [j.ratio for j in found if j.ratio > 0]
    return (
        kind,
        *map(str, (len(found), *counts)),
        f"{statistics.median(over):.2g}" if over else "",
        str(len(ratios)),
        str(sum(r <= RATIO for r in ratios)),
        f"{max(ratios):.2f}" if ratios else "",
    )


def share(found: list[Judged]) -> float:
    promised = [j for j in found if j.promised]
    return sum(j.verdict != MISSED for j in promised) / max(1, len(promised))


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench kept", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="two dozen of the scenes")
    parser.add_argument("--only", default="", help="scenes whose kind or name has this")
    parser.add_argument("--json", type=Path, help="a file for all that was found")
    parser.add_argument("--minutes", type=float, help="scenes drawn at random, as long as this")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--docs", action="store_true", help="write its page")
    arguments = parser.parse_args(words)
    if arguments.docs and (arguments.quick or arguments.only):
        raise SystemExit("bench kept: --docs wants all scenes")
    began, found = time.monotonic(), []
    some = chosen(cases(arguments.quick), arguments.only, lambda case: f"{case.kind}: {case.name}")
    if arguments.minutes:
        random.Random(1).shuffle(some)
    charted = [k % SAMPLED == 0 for k in range(len(some))]
    with ProcessPoolExecutor(arguments.jobs) as pool:
        for j in pool.map(judge, some, charted):
            found.append(j)
            if arguments.minutes and time.monotonic() - began > 60 * arguments.minutes:
                pool.shutdown(wait=False, cancel_futures=True)
                break
            print(
                f"{len(found)}/{len(some)} {j.kind}: {j.name}: {j.verdict}, {j.asked:.0e}, "
                f"{j.reached:.1e}, {j.chosen}, {j.ratio:.2f}, {j.seconds:.1f} s {j.why}",
                file=sys.stderr,
                flush=True,
            )
    drawn = f", drawn of {len(some)}" if len(found) < len(some) else ""
    said = f"{len(found)} scenes{drawn}: kept in {share(found):.1%} of those that are promised"
    said += f"; judged in {time.monotonic() - began:.0f} s"
    missed = "\n".join(f"- {j.name}: {j.why}" for j in found if j.verdict in (MISSED, UNKNOWN))
    text = "\n\n".join(filter(None, (f"{said}.", summary(found), missed)))
    print(text)
    if arguments.json:
        arguments.json.write_text(json.dumps([asdict(j) for j in found], indent=1))
    if arguments.docs:
        before, _, rest = PAGE.read_text(encoding="utf-8").partition(MARKS[0])
        after = rest.partition(MARKS[1])[2]
        here = "; ".join(machine.describe().lines())
        PAGE.write_text(f"{before}{MARKS[0]}\n{here}\n\n{text}\n\n{MARKS[1]}{after}")
    return 0 if share(found) >= GOAL else 4
