"""Reports a choice: in lines of text, and in full as JSON."""

from __future__ import annotations

import math

from .choice import Choice
from .reference import EXACT
from .search import Found

SHOWN = 0.1  # a compilation that takes fewer seconds is not reported


def lines(choice: Choice, time: str, brief: bool) -> list[str]:
    """Returns a line that describes the choice, unless `brief` is set, and warnings if the run may
    miss the accuracy."""
    said = []
    setting = f"{choice.kind} {choice.setting:.3g}"
    if choice.max_step is not None:
        setting += f", steps of at most {choice.max_step:.3g}"
    expected = f"expected error {choice.expected:.1e}, " if math.isfinite(choice.expected) else ""
    if not brief:
        compiled = f", {choice.compile_seconds:.2g} s to compile them"
        of = f" of {', '.join(choice.of)}" if choice.of else ""
        sampled = f" of {choice.sampled} members" if choice.sampled else ""
        said.append(
            f"accuracy {choice.accuracy:g}{of}: {choice.method}, {setting}, {expected}"
            f"{choice.seconds:.2g} s of trials{sampled}"
            f"{compiled if choice.compile_seconds >= SHOWN else ''}"
        )
    if choice.left_out:
        said.append(
            f"pkgen: {', '.join(choice.left_out)}: zero but for errors of round-off, so no "
            "accuracy is promised of it"
        )
    if choice.unsure:
        said.append(
            f"pkgen: {', '.join(choice.unsure)}: the tightest runs differ by more than "
            f"{choice.accuracy:g} of what it compares, so no accuracy is promised of that"
        )
    if choice.without:
        said.append(
            "pkgen: the event that has rows does not happen in trials: the accuracy is of what is "
            "recorded at the end"
        )
    warning = _warning(choice, time)
    return [*said, f"pkgen: warning: accuracy {choice.accuracy:g} {warning}"] if warning else said


def _warning(choice: Choice, time: str) -> str:
    def at(t: float) -> str:
        return f"t = {t:.6g} {time}".rstrip()

    if choice.check.ends:
        return "is not promised: no method arrives at the end"
    if choice.given_up is not None:
        came = choice.given_up
        return (
            f"was tried until {at(choice.check.span)} alone, and what was not tried is not "
            f"promised: a trial of all of it was given up after {came.seconds:.2g} s at "
            f"{at(came.t)}. The run goes to {at(came.until)}, by the part that was tried in "
            f"{choice.run_seconds:.2g} s; --until or a looser accuracy make it shorter, Ctrl-C "
            "keeps the rows so far"
        )
    if choice.horizon is None:
        return ""
    if choice.without:
        return f"of what is recorded at the end is not kept: {_apart(choice)}"
    if choice.horizon == 0:
        return f"is not kept: {_apart(choice)}"
    return f"holds until {at(choice.horizon)}: from there on {_apart(choice)}"


def _apart(choice: Choice) -> str:
    """Describes the difference of the two tightest runs. Its cause is round-off or too long steps;
    a comparison of runs cannot tell which. For an exact flow, only round-off is possible."""
    if choice.check.method == EXACT:
        return f"for round-off the tightest run is known to {choice.expected:.1e}"
    if choice.check.in_more_digits:
        return (
            f"the best of all runs is off by {choice.expected:.1e} of one in more digits, for "
            "round-off that the motion magnifies"
        )
    much = f" by {choice.expected:.1e}" if math.isfinite(choice.expected) else ""
    return (
        f"two of the tightest runs differ{much}, by round-off that the motion magnifies or by "
        "something shorter than their steps (--max-step)"
    )


def record(choice: Choice) -> dict[str, object]:
    check = choice.check
    return {
        **({"of": list(choice.of)} if choice.of else {}),
        "asked": choice.accuracy,
        "method": choice.method,
        "rows": choice.rows,
        choice.kind: choice.setting,
        "max_step": choice.max_step,
        "expected": _finite(choice.expected),
        "horizon": choice.horizon,
        "unverified_from": None if choice.given_up is None else check.span,
        "ends": check.ends or None,
        "run_seconds": _finite(choice.run_seconds),
        "trial_seconds": choice.seconds,
        "compile_seconds": choice.compile_seconds,
        "members_tried": choice.sampled,
        "reference": {
            "method": check.method,
            "step" if check.method == EXACT else "rtol": check.exact.setting,
            "until": check.span,
            "error": _finite(check.floor),
            "from": check.against,
            "left_out": [*choice.left_out, *choice.unsure],
            "without_rows": choice.without,
        },
        "evidence": [_evidence(f, choice) for f in choice.found],
    }


def _evidence(found: Found, choice: Choice) -> dict[str, object]:
    kept, candidate = found.kept, found.candidate
    chosen = kept is not None and (kept.method, kept.rows) == (choice.method, choice.rows)
    best = kept or min(found.tried, key=lambda t: t.error)
    return {
        "method": candidate.name,
        "rows": candidate.rows,
        "why": candidate.why,
        candidate.method.setting: best.setting,
        "error": _finite(best.error),
        "seconds": _finite(best.seconds),
        "trials": len(found.tried),
        "verdict": "chosen" if chosen else "kept" if kept else found.verdict,
    }


def _finite(x: float) -> float | None:
    return x if math.isfinite(x) else None
