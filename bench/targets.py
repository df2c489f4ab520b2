"""The figures to reach, each a ratio within this run, and whether it was reached."""

from __future__ import annotations

import statistics
from dataclasses import dataclass

from . import chains, ensembles, matching
from .kernels import Timing
from .longrun import LongRun
from .measure import Comparison, Track
from .turns import Timing as TurnTiming

# How a stepper is compiled makes two contenders of it; the better one counts.
OWN_DOP853 = ("pkgen dop853", "pkgen dop853 (function pointer)")
HEYOKA_ERRORS = (1e-6, 1e-8, 1e-10, 1e-12)


@dataclass(frozen=True)
class Row:
    """`values` by model, or under "" where there is one number; `reached` of how many."""

    what: str
    least: str
    values: dict[str, str]
    reached: int
    of: int

    @property
    def verdict(self) -> str:
        if not self.of:
            return "of a shorter run"
        if self.of == 1:
            return "reached" if self.reached else "not reached"
        return f"reached on {self.reached} of {self.of}"


def single(what: str, least: str, value: float, reached: bool, unit: str = "×") -> Row:
    return Row(what, least, {"": f"{value:.3g}{unit}"}, int(reached), 1)


def kernel_rows(timings: dict[str, Timing]) -> list[Row]:
    if "own" not in timings:
        return []
    own = statistics.median(timings["own"].rounds)
    rows = []
    for name, least, faster in (
        ("floor", "≤ 0.85", None),
        ("ldl", "1.8×", 1.8),
        ("pydy", "-", 1.0),
        ("cholesky", "6×", 6.0),
    ):
        if name not in timings:
            continue
        peer = statistics.median(timings[name].rounds)
        what = f"double-pendulum acceleration against {timings[name].kernel.title}"
        if faster is None:
            rows.append(single(what, least, own / peer, own / peer <= 0.85, ""))
        else:
            rows.append(single(what, least, peer / own, peer / own >= faster))
    return rows


def ensemble_rows(timings: dict[str, TurnTiming], batch: list[TurnTiming]) -> list[Row]:
    """Own time against that of each peer, in nanoseconds of a member's step."""
    scalar = ("scalar libm", "scalar libm, pkgen --libm")
    rows = [
        _turns("ensemble, double, against scalar libm", 7, timings, "pkgen", scalar),
        _turns("ensemble, double, against libmvec", 1.4, timings, "pkgen", ("libmvec",)),
        _turns("ensemble, double, against numpy", 10, timings, "pkgen", ("numpy",)),
        _turns("ensemble, double, against numba", 1, timings, "pkgen", ("numba",)),
        _turns(
            "ensemble, float, against scalar libm in float",
            17,
            timings,
            "float: pkgen",
            tuple(f"float: {name}" for name in scalar),
        ),
        _turns("two threads against one", 1.9, timings, "pkgen, two threads", ("pkgen",)),
    ]
    found = [row for row in rows if row]
    if "pkgen" in timings and batch:
        own = timings["pkgen"]
        match = ensembles.heyoka_seconds(batch, ensembles.rk4_error(own))
        if match:
            times = match.seconds / (1e-9 * own.median * ensembles.STEPS)
            found.append(
                single("heyoka's batch mode on the same work", "1.5×", times, times >= 1.5)
            )
    return found


def chain_rows(found: dict[int, dict[str, TurnTiming]]) -> list[Row]:
    if any("pkgen" not in by_title for by_title in found.values()):
        return []
    rows = []
    for n in sorted(n for n in found if n >= chains.SIZES[-1]):
        what = f"FPUT chain, N = {n:.0e}".replace("e+0", "e") + ", Verlet, "
        roof = found[n]["pkgen"].median / found[n]["roofline, one pass"].median
        rows.append(single(f"{what}against the one-pass roofline", "≤ 1.1", roof, roof <= 1.1, ""))
    found = {n: by_title for n, by_title in found.items() if n != chains.BEYOND}
    largest = found[max(found)]
    what = f"FPUT chain, N = {max(found):.0e}".replace("e+0", "e") + ", Verlet, "
    for peer, least in (("numpy", 8), ("force callback", 3), ("numba", 1)):
        row = _turns(f"{what}against {peer}", least, largest, "pkgen", (peer,))
        rows += [row] if row else []
    costs = [by_title["pkgen"].median for by_title in found.values()]
    grows = max(costs) / min(costs)
    sizes = f"N = {min(found):,} to {max(found):,}"
    rows.append(single(f"cost a mass-step, {sizes}, within", "≤ 3", grows, grows <= 3, ""))
    return rows


def derivation_rows(found: dict[int, dict[str, float]]) -> list[Row]:
    twenty, hundred = found[20], found[100]
    return [
        _at_most("20-link pendulum: derive and emit", 50, 1e3 * twenty["emit_seconds"], " ms"),
        _at_most("20-link pendulum: operations of M and f", 2000, twenty["operations"], ""),
        _at_most("20-link pendulum: gcc -O2", 1, twenty["gcc_seconds"], " s"),
        _at_most("100-link pendulum: derive", 1, hundred["derive_seconds"], " s"),
        _at_most("100-link pendulum: gcc -O2", 30, hundred["gcc_seconds"], " s"),
    ]


def long_rows(run: LongRun) -> list[Row]:
    what = f"Kepler, e = 0.6, gauss8, {run.periods:,} periods, {run.starts} starts: "
    asked = int(run.periods >= 1e6)  # a quick run says nothing about a million periods
    error, growth = {"": f"{run.rms:.2g}"}, {"": f"{run.exponent:.2g}"}
    return [
        Row(f"{what}rms relative energy error", "≤ 5e-13", error, int(run.rms <= 5e-13), asked),
        Row(f"{what}growth exponent", "≤ 0.6", growth, int(run.exponent <= 0.6), asked),
    ]


def _at_most(what: str, most: float, value: float, unit: str) -> Row:
    shown = f"{value:.0f}" if value >= 100 else f"{value:.3g}"
    return Row(what, f"≤ {most:g}{unit}", {"": shown + unit}, int(value <= most), 1)


def _turns(
    what: str, least: float, timings: dict[str, TurnTiming], own: str, peers: tuple[str, ...]
) -> Row | None:
    """How many times faster than the fastest of the peers, turn by turn."""
    present = [timings[name] for name in peers if name in timings]
    if own not in timings or not present:
        return None
    peer = min(present, key=lambda t: t.median)
    found = matching.ratio(peer.rounds, timings[own].rounds)
    return single(what, f"{least:g}×", found.median, found.median >= least)


def method_rows(comparisons: list[Comparison]) -> list[Row]:
    rows = []
    for error in (1e-10, 1e-12):
        rows.append(_faster(comparisons, error, "pkgen's own C DOP853", OWN_DOP853, 3))
        rows.append(_faster(comparisons, error, "GSL rk8pd on pkgen's kernel", ("GSL rk8pd",), 4))
    cvode = ("CVODE Adams", "CVODE BDF")
    rows.append(_faster(comparisons, 1e-10, "CVODE", cvode, 15))
    rows.append(_faster(comparisons, 1e-10, "SciPy DOP853", ("SciPy DOP853",), 500))
    numba = "SciPy DOP853 + numba"
    rows.append(_faster(comparisons, 1e-10, numba, (numba,), 1, said="-"))
    for error in HEYOKA_ERRORS:
        rows.append(_faster(comparisons, error, "heyoka", ("heyoka",), 1))
    for error in HEYOKA_ERRORS:
        name = "heyoka (par)"
        rows.append(_faster(comparisons, error, f"{name}, run-time parameters", (name,), 1))
    for error, least in ((1e-3, 1.0), (1e-6, 1.4)):
        rows.append(
            _faster(
                comparisons,
                error,
                "the best other in C (DOP853, GSL, CVODE, RK4; not heyoka)",
                None,
                least,
            )
        )
    # There pkgen's own choice is dop853 on most models.
    title = "the same without pkgen's DOP853, which pkgen may use as well"
    rows.append(_faster(comparisons, 1e-3, title, None, 1, said="-", dop853_is_own=True))
    return rows


def _faster(
    comparisons: list[Comparison],
    error: float,
    title: str,
    peers: tuple[str, ...] | None,
    least: float,
    said: str = "",
    dop853_is_own: bool = False,
) -> Row:
    """How many times faster pkgen's best is than the best peer; None: than all in C but heyoka.
    Its DOP853 is among those peers unless it is its own."""
    values, reached = {}, 0
    mine, theirs = (OWN_DOP853, ()) if dop853_is_own else ((), OWN_DOP853)
    for comparison in comparisons:
        names = peers or (*_others(comparison), *theirs)
        own = best(comparison, (*_own(comparison), *mine), error)
        peer = best(comparison, names, error)
        present = any(t.name in names for t in comparison.tracks)
        text, good = _ratio(own, peer, error, least, present)
        values[comparison.model.name] = text
        reached += good
    what = f"to {error:.0e} against {title}".replace("e-0", "e-")
    return Row(what, said or f"{least:g}×", values, reached, len(comparisons))


def _own(comparison: Comparison) -> tuple[str, ...]:
    return tuple(
        t.name
        for t in comparison.tracks
        if t.contender.group == "pkgen" and t.name not in OWN_DOP853
    )


def _others(comparison: Comparison) -> tuple[str, ...]:
    in_c = [t.name for t in comparison.tracks if t.contender.group == "C"]
    return tuple(n for n in in_c if not n.startswith("heyoka"))


def best(comparison: Comparison, names: tuple[str, ...], error: float) -> Track | None:
    """The fastest of the named ones at this error."""
    found = [
        (match.seconds, track)
        for track in comparison.tracks
        if track.name in names
        for match in [matching.seconds_at(track.curve(), error)]
        if match
    ]
    return min(found, key=lambda pair: pair[0])[1] if found else None


def _ratio(
    own: Track | None, peer: Track | None, error: float, least: float, taking_part: bool
) -> tuple[str, bool]:
    if own is None:
        return "own: never" if peer else "neither", False
    if peer is None:
        return ("peer: never", True) if taking_part else ("no peer", False)
    rounds = min(len(own.seconds), len(peer.seconds))
    found = matching.ratio(
        [m.seconds for m in peer.matched(error)[:rounds]],
        [m.seconds for m in own.matched(error)[:rounds]],
    )
    mark = "≥ " if _bound(own, error) else "≤ " if _bound(peer, error) else ""
    return f"{mark}{found.median:.3g} [{found.low:.3g}, {found.high:.3g}]", found.median >= least


def _bound(track: Track, error: float) -> bool:
    match = matching.seconds_at(track.curve(), error)
    return match is not None and match.bound
