"""What is said of a choice: a line to a person, all of it in JSON."""

from __future__ import annotations

import math

from .choose import Choice
from .search import Found

NOT_PROMISED = (
    "the scene's accuracy is not promised: --method, --step, --rtol or --atol choose in its place"
)


def lines(choice: Choice, time: str, brief: bool) -> list[str]:
    """The choice, unless `brief`, and a warning where it does not hold."""
    said = []
    setting = f"{'step' if choice.fixed else 'rtol'} {choice.setting:.3g}"
    expected = f"expected error {choice.expected:.1e}, "
    if choice.unverified is not None:
        expected = ""
        said.append(
            f"pkgen: warning: accuracy {choice.accuracy:g} was tried until t = "
            f"{choice.unverified:.6g} {time}".rstrip()
            + " alone, for trials of all of it take too long; behind that it is not promised"
        )
    if not brief:
        said.append(
            f"accuracy {choice.accuracy:g}{_of(choice)}: {choice.method}, {setting}, {expected}"
            f"{choice.seconds:.2g} s of trials{_sampled(choice)}"
        )
    if choice.left_out:
        said.append(
            f"pkgen: {', '.join(choice.left_out)}: zero but for errors of round-off, so no "
            "accuracy is promised of it"
        )
    if choice.horizon is not None:
        until = f"t = {choice.horizon:.6g} {time}".rstrip()
        said.append(
            f"pkgen: warning: accuracy {choice.accuracy:g} holds until {until}: two of the "
            "tightest runs differ by more from there on, for errors of round-off have grown to it"
        )
    return said


def _of(choice: Choice) -> str:
    return f" of {', '.join(choice.of)}" if choice.of else ""


def _sampled(choice: Choice) -> str:
    return f" of {choice.sampled} members" if choice.sampled else ""


def record(choice: Choice) -> dict[str, object]:
    check = choice.check
    return {
        **({"of": list(choice.of)} if choice.of else {}),
        "asked": choice.accuracy,
        "method": choice.method,
        "rows": choice.rows,
        "step" if choice.fixed else "rtol": choice.setting,
        "expected": _finite(choice.expected),
        "horizon": choice.horizon,
        "unverified_from": choice.unverified,
        "run_seconds": _finite(choice.run_seconds),
        "trial_seconds": choice.seconds,
        "members_tried": choice.sampled,
        "reference": {
            "method": check.method,
            "rtol": check.setting,
            "until": check.span,
            "error": _finite(check.floor),
            "from": check.against,
            "left_out": list(choice.left_out),
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
        "step" if candidate.method.fixed else "rtol": best.setting,
        "error": _finite(best.error),
        "seconds": _finite(best.seconds),
        "trials": len(found.tried),
        "verdict": "chosen" if chosen else "kept" if kept else found.verdict,
    }


def _finite(x: float) -> float | None:
    return x if math.isfinite(x) else None
