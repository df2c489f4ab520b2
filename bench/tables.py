"""What is printed: Markdown tables, which read well in a terminal too, and CSV."""

from __future__ import annotations

import csv
import statistics
from collections.abc import Iterable, Sequence
from pathlib import Path

from . import matching
from .kernels import Timing
from .measure import Comparison
from .targets import Row
from .turns import Timing as TurnTiming

ERRORS = (1e-3, 1e-6, 1e-8, 1e-10, 1e-12)


def table(heading: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Aligned, the first column left and all others right."""
    cells = [list(heading), *([str(x) for x in row] for row in rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(heading))]

    def line(row: Sequence[str]) -> str:
        first, *rest = (
            c.ljust(w) if not i else c.rjust(w)
            for i, (c, w) in enumerate(zip(row, widths, strict=True))
        )
        return "| " + " | ".join([first, *rest]) + " |"

    rule = ["-" * (w + 2) if not i else "-" * (w + 1) + ":" for i, w in enumerate(widths)]
    return "\n".join(
        [line(cells[0]), "|" + "|".join(rule) + "|"] + [line(row) for row in cells[1:]]
    )


def targets(rows: list[Row], models: list[str]) -> str:
    """Rows of one number first, then those with one a model."""
    plain = [r for r in rows if "" in r.values]
    by_model = [r for r in rows if "" not in r.values]
    parts = []
    if plain:
        cells = [(r.what, r.least, r.values[""], r.verdict) for r in plain]
        parts.append(table(("what", "at least", "measured", ""), cells))
    if by_model:
        cells = [(r.what, r.least, *(r.values[m] for m in models), r.verdict) for r in by_model]
        heading = ("pkgen's best method", "at least", *(m.replace("_", " ") for m in models), "")
        parts.append(table(heading, cells))
    return "\n\n".join(parts)


def methods(comparison: Comparison) -> str:
    """Microseconds to each final error, by the fastest build of each contender."""
    rows = []
    for track in comparison.tracks:
        cells = [_microseconds(matching.seconds_at(track.curve(), e)) for e in ERRORS]
        rows.append((track.name, *cells, track.session.flags))
    heading = ("µs to a final error of", *(_power(e) for e in ERRORS), "built with")
    return table(heading, rows)


def refusals(comparison: Comparison) -> list[str]:
    return [f"- {name}: {why}" for name, why in comparison.refused.items()]


def kernels(timings: dict[str, Timing]) -> str:
    rows = []
    for timing in timings.values():
        low, high = matching.quartiles(timing.rounds)
        median = statistics.median(timing.rounds)
        spread = f"[{low:.1f}, {high:.1f}]"
        rows.append((timing.kernel.title, f"{median:.1f}", spread, timing.build))
    heading = ("double-pendulum acceleration", "ns", "quartiles", "built with")
    return table(heading, rows)


def turns(heading: str, timings: dict[str, TurnTiming]) -> str:
    rows = []
    for timing in timings.values():
        low, high = matching.quartiles(timing.rounds)
        spread = f"[{low:.3g}, {high:.3g}]"
        rows.append((timing.title, f"{timing.median:.3g}", spread, timing.flags))
    return table((heading, "ns", "quartiles", "built with"), rows)


def chains(found: dict[int, dict[str, TurnTiming]]) -> str:
    """Nanoseconds a mass-step, a column a size; the build is that of the largest."""
    titles = list(dict.fromkeys(title for by_title in found.values() for title in by_title))
    rows = []
    for title in titles:
        cells = [f"{b[title].median:.3g}" if title in b else "-" for b in found.values()]
        rows.append((title, *cells, found[max(found)][title].flags))
    return table(("ns a mass-step, N =", *(f"{n:,}" for n in found), "built with"), rows)


def derivation(found: dict[int, dict[str, float]]) -> str:
    rows = [
        (
            n,
            f"{r['derive_seconds']:.3f}",
            f"{r['emit_seconds']:.3f}",
            f"{r['operations']:,}",
            f"{r['gcc_seconds']:.2f}",
        )
        for n, r in found.items()
    ]
    heading = ("links; M and f", "derive (s)", "and emit (s)", "operations", "gcc -O2 (s)")
    return table(heading, rows)


def _microseconds(match: matching.Match | None) -> str:
    if match is None:
        return "-"
    text = f"{1e6 * match.seconds:.3g}" if match.seconds < 1e-3 else f"{1e6 * match.seconds:.0f}"
    return f"≤ {text}" if match.bound else text


def _power(x: float) -> str:
    return f"{x:.0e}".replace("e-0", "e-")


def write_csv(path: Path, heading: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(heading)
        writer.writerows(rows)


def points(comparisons: list[Comparison]) -> Iterable[tuple]:
    """All that was measured, a line a setting, start and round."""
    for c in comparisons:
        for t in c.tracks:
            for number, times in enumerate(t.seconds):
                for setting, errors, seconds in zip(t.settings, t.errors, times, strict=True):
                    for start, (error, took) in enumerate(zip(errors, seconds, strict=True)):
                        yield (c.model.name, t.name, setting, start, number, took, error)


def builds(comparisons: list[Comparison], timings: dict[str, Timing]) -> Iterable[tuple]:
    """All builds that were tried, with the time that decided."""
    for c in comparisons:
        for t in c.tracks:
            for flags, seconds in t.trials.items():
                yield (c.model.name, t.name, flags, seconds, flags == t.session.flags)
    for timing in timings.values():
        for flags, nanoseconds in timing.builds.items():
            taken = flags == timing.build
            yield ("double_pendulum", timing.kernel.title, flags, nanoseconds * 1e-9, taken)
