"""`python -m bench [--quick] [--own] [--models NAME,...] [--docs]`; see `make bench`."""

from __future__ import annotations

import argparse
import os
import sys
import time

from . import chart, kernels, machine, measure, models, reference, tables, targets
from .builds import OUTPUT
from .peers import cvode, gsl, mechanicsdsl, own, python, taylor
from .report import write_docs

PEERS = (own, gsl, cvode, taylor, mechanicsdsl, python)


def main() -> int:
    arguments = _arguments()
    effort = measure.QUICK if arguments.quick else measure.FULL
    names = arguments.models.split(",") if arguments.models else list(models.LAGRANGIANS)
    sources = PEERS[:1] if arguments.own else PEERS
    contenders = [c for source in sources for c in source.contenders()]
    here = machine.describe()
    _say("\n".join(here.lines()))

    begin = time.monotonic()
    timings, unmade = kernels.measure(effort, _say)
    comparisons = []
    for name in names:
        model = models.model(name)
        exact = reference.finals(model, model.starts(effort.starts))
        comparisons.append(measure.compare(model, contenders, exact, effort, _say))
    _say(f"measured in {time.monotonic() - begin:.0f} s; load now {os.getloadavg()[0]:.2f}")

    rows = targets.kernel_rows(timings) + targets.method_rows(comparisons)
    parts = {
        "Figures to reach": tables.targets(rows, names),
        "Kernels": tables.kernels(timings),
    }
    for c in comparisons:
        text = [tables.methods(c), *tables.refusals(c)]
        parts[c.model.name.replace("_", " ").capitalize()] = "\n\n".join(
            [text[0], "\n".join(text[1:])] if c.refused else text
        )
    if unmade:
        parts["Kernels"] += "\n\n" + "\n".join(f"- {k}: {why}" for k, why in unmade.items())
    for title, text in parts.items():
        print(f"\n## {title}\n\n{text}")
    _save(comparisons, timings, rows, here)
    if arguments.docs:
        write_docs(parts, here, effort)
    return 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a minute or two, fewer starts")
    parser.add_argument("--own", action="store_true", help="pkgen's methods alone")
    parser.add_argument("--models", help="names, separated by commas; default: all five")
    parser.add_argument("--docs", action="store_true", help="write docs/benchmarks.md")
    return parser.parse_args()


def _save(comparisons, timings, rows, here) -> None:
    OUTPUT.mkdir(parents=True, exist_ok=True)
    tables.write_csv(
        OUTPUT / "points.csv",
        ("model", "contender", "setting", "start", "round", "seconds", "error"),
        tables.points(comparisons),
    )
    tables.write_csv(
        OUTPUT / "builds.csv",
        ("model", "contender", "build", "seconds", "taken"),
        tables.builds(comparisons, timings),
    )
    tables.write_csv(
        OUTPUT / "targets.csv",
        ("what", "at least", "model", "measured", "verdict"),
        ((r.what, r.least, m, x, r.verdict) for r in rows for m, x in r.values.items()),
    )
    try:
        chart.draw(comparisons, timings, here, OUTPUT / "chart.png")
        saved = "points.csv, builds.csv, targets.csv, chart.png, chart.svg"
    except ImportError:
        saved = "points.csv, builds.csv, targets.csv (no chart: matplotlib is missing)"
    _say(f"in {OUTPUT}: {saved}")


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
