"""What `pkgen run --diagnose` asks for, and its results as lines for a person.

They are made in C, runtime/run/diagnose.c; docs/diagnostics.md has their names and keys.
"""

from __future__ import annotations

from .back.kernels import KERNELS
from .exits import UsageError
from .option_values import near

NAMES = ("lyapunov", "reversal", "spectrum", "symplectic", "least_action")
UNIFORM = 1e-9  # of a coordinate's size: what is left of it beside a mean and a rate
BROAD = 0.03  # a residual that lines do not explain
LINEARISED = frozenset(("all", "lyapunov", "symplectic", "least_action"))  # by the kernel `linear`


def asked(text: str | None, ensemble: str | None = None) -> tuple[str, ...]:
    """`--diagnose lyapunov,spectrum`, each once, or `all`: those that apply."""
    if text is None:
        return ()
    if ensemble is not None:
        raise UsageError("--diagnose is for one trajectory, not for --ensemble")
    if text.strip() == "all":
        return ("all",)
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in NAMES:
            known = [*NAMES, "all"]
            raise UsageError(
                f"--diagnose {text}: there is no '{name}'; {near(name, known, 'diagnostic')}"
            )
    return tuple(name for name in NAMES if name in names)


def kernels(names: tuple[str, ...]) -> frozenset[str] | None:
    """All of them where `linear` is needed, which a large model leaves out unless it is named."""
    return frozenset(KERNELS) if LINEARISED.intersection(names) else None


def drift_lines(drifts: list[dict]) -> list[str]:
    """Two lines a constant: its drift, and how that grows."""
    said = []
    for drift in drifts:
        name, scale = drift["name"], drift["scale"]
        if drift["max"] is None or drift["exponent"] is None:
            said.append(f"drift({name}): {drift['growth']}")
            continue
        line = f"drift({name}) max {drift['max']:.2e}, final {drift['final']:.2e}"
        line += f", slope {drift['slope']:.1e} per unit of time, relative to {scale:.2g}"
        growth = drift["growth"]
        if drift["exponent"] or drift["spread"]:
            growth += f" (t^{drift['exponent']:.2f})"
        if not drift["first"] and scale:
            growth += f"; it starts at 0, so this is relative to its own largest value, {scale:.1e}"
        said.append(f"{line}: {growth}")
    return said


def lines(found: dict[str, dict], time: str) -> list[str]:
    """The results in words; `time` is the unit of time. What failed the driver has said."""
    said = []
    for name, result in found.items():
        if result["status"] == "PK_DONE":
            said += _TEXTS[name](result, time)
    return said


def _per(time: str) -> str:
    return f" /{time}" if time else ""


def _lyapunov(found: dict, time: str) -> list[str]:
    if found["error"] is None:
        return ["lyapunov: too few steps to tell"]
    value = f"{found['exponent']:.4g} +- {found['error']:.2g}{_per(time)}"
    megno = f"megno {found['megno']:.3g}"
    if found["motion"] == "leaving":
        return [
            f"lyapunov: displacements grow exponentially, exponent {value}: an instability and no "
            "chaos as far as this goes, for the motion still leaves its start, or rests there, or "
            "has one coordinate alone and no explicit time"
        ]
    if found["motion"] == "chaotic":
        return [f"lyapunov: chaotic, exponent {value} ({megno})"]
    if found["motion"] == "regular":
        return [
            f"lyapunov: regular over this time ({megno}: 2 of a quasi-periodic motion, 0 of a "
            f"harmonic one); exponent {value}, of which a regular motion leaves some 2.6/time"
        ]
    return [f"lyapunov: undecided ({megno}: between 3 and 6); exponent {value}; take a longer time"]


def _reversal(found: dict, time: str) -> list[str]:
    unit = f" {time}" if time else ""
    at, error = max(found["times"])
    if found["lost"]:
        said = (
            f"reversal: there and back, the start is lost to {found['threshold']:g} between "
            f"{found['horizon_lo']:.4g} and {found['horizon_hi']:.4g}{unit}"
        )
    else:
        said = f"reversal: there and back over {at:.4g}{unit} misses the start by {error:.1e}"
    if found["predicted"] is not None:
        said += f"; round-off alone would lose it near {found['predicted']:.4g}{unit}"
    if not found["symmetric"]:
        said += "; the method is not symmetric, so the error is its own too"
    return [said]


def _spectrum(found: dict, time: str) -> list[str]:
    unit = f" rad/{time}" if time else ""
    said = []
    for coordinate in found["coordinates"]:
        shown = [
            f"{line['frequency']:.10g} +- {line['error']:.0e} (amplitude {line['amplitude']:.3g})"
            for line in coordinate["lines"][:3]
        ]
        if not shown and coordinate["away"] < UNIFORM:
            said.append(f"spectrum: {coordinate['name']}: {_uniform(coordinate, time)}")
            continue
        text = ", ".join(shown) + unit if shown else "no line"
        left = coordinate["residual"]
        said.append(f"spectrum: {coordinate['name']}: {text}; {left:.1e} left by all lines")
        if left > BROAD:
            said[-1] += ": more than lines, or the time is too short to tell them apart"
    return said


def _uniform(coordinate: dict, time: str) -> str:
    if coordinate["drifts"] < UNIFORM:
        return f"constant, {coordinate['mean']:.6g}"
    return f"goes uniformly, by {coordinate['rate']:.10g}{_per(time)}; it does not oscillate"


def _symplectic(found: dict, time: str) -> list[str]:
    said = f"symplectic: of {found['states']} steps of {found['step']:.4g} the worst misses by "
    said += f"{found['defect']:.1e}, its volume by {found['volume']:.1e}; "
    if found["symplectic"]:
        said += f"that is round-off (below {found['rounding']:.0e})"
    else:
        said += f"round-off would be below {found['rounding']:.0e}"
    if not found["variational"]:
        said += "; the motion itself, with forces besides those of L, is not symplectic"
    if found["failed"]:
        said += f"; {found['failed']} more could not be made"
    return [said]


def _least_action(found: dict, time: str) -> list[str]:
    said = f"least_action: {found['action']:.12g} over {found['time']:.6g}"
    said += f"{f' {time}' if time else ''}, stationary to {found['slope']:.0e}; "
    points = ", ".join(f"{t:.10g}" for t in found["conjugate"][:4])
    points += ", ..." if found["conjugate"][4:] else ""
    if found["minimum"]:
        said += "a minimum among paths with the same ends"
    else:
        least = "" if found["settled"] else "at least "
        ways = "one way" if found["index"] == 1 else f"{found['index']} independent ways"
        said += f"no minimum: {least}{ways} to a neighbour with less"
    if points:
        said += f"; conjugate to the start: t = {points}"
    return [said]


_TEXTS = {
    "lyapunov": _lyapunov,
    "reversal": _reversal,
    "spectrum": _spectrum,
    "symplectic": _symplectic,
    "least_action": _least_action,
}
