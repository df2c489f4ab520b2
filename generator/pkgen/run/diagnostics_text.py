"""Formats drifts and the results of `pkgen run --diagnose` as lines of text."""

from __future__ import annotations

import math

UNIFORM = 1e-9  # a relative deviation from uniform motion, or from rest, counts as 0 below this
NO_TORQUE = 1e-12  # a torque smaller than this, relative to the terms that it sums, is round-off
CONJUGATE_SHOWN = 64  # most conjugate points in a report
OFF, SHOWN = 1e-3, 5  # a larger drift is reported as an error; most constants named in a line
# A constant has lost digits if its drift, relative to its value, is at least LOST and at least
# MAGNIFIED times drift["max"], the drift relative to the terms that the constant sums.
LOST, MAGNIFIED = 1e-6, 1e3
EPSILON = 1e-13  # a value below this part of the scale is 0 up to rounding
BROAD = 0.03  # largest residual of a motion that spectral lines explain


def kept_line(drifts: list[dict]) -> list[str]:
    """Returns one line with the drifts of all constants of motion, then a line for each constant
    that lost digits (see _lost()). Returns [] if there are no constants."""
    said = []
    for drift in drifts:
        name, most = drift["name"], drift["max"]
        if most is None:
            said.append(f"{name} not finite")
        elif most > OFF:
            said.append(f"{name} off by {most:.1e} of its scale")
        else:
            said.append(f"{name} kept " + (f"to {most:.0e}" if most else "exactly"))
    if len(said) > SHOWN:
        most = max(drift["max"] or 0.0 for drift in drifts[SHOWN:])
        said[SHOWN:] = [f"{len(said) - SHOWN} more to {most:.0e}"]
    lost = [f"{drift['name']}{text}" for drift in drifts if (text := _lost(drift))]
    return [", ".join(said), *lost] if said else []


def drift_lines(drifts: list[dict]) -> list[str]:
    """Returns a line for each constant: its drift, and how the drift grows with time."""
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
        if not drift["first"] and drift["max"] == 1:  # `scale` is the constant's largest value
            growth += f"; it starts at 0, so this is relative to its own largest value, {scale:.1e}"
        said.append(f"{line}: {growth}{_lost(drift).replace(': ', '; ', 1)}")
    return said


def _lost(drift: dict) -> str:
    """Returns a remark if a constant is so small compared with the terms of its sum that it loses
    digits, else ""."""
    first, scale = abs(drift["first"]), drift["scale"]
    if drift["max"] is None:
        return ""
    off = drift["max"] * scale / first if first > EPSILON * scale else 0.0
    if off < LOST or off < MAGNIFIED * drift["max"]:
        return ""
    return f": of its own value {drift['first']:.2g} that is {off:.1e}: digits are lost"


def lines(found: dict[str, dict], time: str) -> list[str]:
    """Returns the results of all diagnostics in words; `time` is the unit of time. Diagnostics that
    failed are left out, since the runtime reports them."""
    said = []
    for name, result in found.items():
        if result["status"] == "PK_DONE":
            said += _TEXTS[name](result, time)
    return said


def _few(numbers: list[str], unit: str) -> str:
    more = f" and {len(numbers) - 4} more" if len(numbers) > 4 else ""
    return f"{', '.join(numbers[:4])}{unit}{more}"


def _in(time: str, before: str = "") -> str:
    return f" {before}{time}" if time else ""


def _per(time: str) -> str:
    return _in(time, "/")


def _lyapunov(found: dict, time: str) -> list[str]:
    if found["error"] is None:
        return ["lyapunov: too few steps to tell"]
    value = f"{found['exponent']:.4g} +- {found['error']:.2g}{_per(time)}"
    megno = f"megno {found['megno']:.3g}"
    if found["motion"] == "leaving":
        return [
            f"lyapunov: displacements grow exponentially, exponent {value}: an instability and no "
            "chaos as far as this goes, for the motion still leaves its start, or rests there, or "
            "has one coordinate, or two states, alone and no explicit time"
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
    at, error = max(found["times"])
    if found["lost"]:
        said = (
            f"reversal: there and back, the start is lost to {found['threshold']:g} between "
            f"{found['horizon_lo']:.4g} and {found['horizon_hi']:.4g}{_in(time)}"
        )
    else:
        said = f"reversal: there and back over {at:.4g}{_in(time)} misses the start by {error:.1e}"
    if found["predicted"] is not None:
        said += f"; round-off alone would lose it near {found['predicted']:.4g}{_in(time)}"
    if not found["symmetric"]:
        said += "; the method is not symmetric, so the error is its own too"
    return [said]


def _spectrum(found: dict, time: str) -> list[str]:
    unit, said = _in(time, "rad/"), []
    for coordinate in found["coordinates"]:
        shown = [
            f"{line['frequency']:.10g} +- {line['error']:.0e} (amplitude {line['amplitude']:.3g})"
            for line in coordinate["lines"][:3]
        ]
        if not shown and coordinate["away"] < UNIFORM:
            text = f"constant, {coordinate['mean']:.6g}"
            if coordinate["drifts"] >= UNIFORM:
                text = f"goes uniformly, by {coordinate['rate']:.10g}{_per(time)}"
                text += "; it does not oscillate"
            said.append(f"spectrum: {coordinate['name']}: {text}")
            continue
        text = ", ".join(shown) + unit if shown else "no line"
        left = coordinate["residual"]
        said.append(f"spectrum: {coordinate['name']}: {text}; {left:.1e} left by all lines")
        if left > BROAD:
            said[-1] += ": more than lines, or the time is too short to tell them apart"
    return said


def _symplectic(found: dict, time: str) -> list[str]:
    said = f"symplectic: of {found['states']} steps of {found['step']:.4g} the worst misses by "
    said += f"{found['defect']:.1e}, its volume by {found['volume']:.1e}; "
    if found["symplectic"]:
        said += f"that is round-off (below {found['rounding']:.0e})"
    else:
        said += f"round-off would be below {found['rounding']:.0e}"
    if not found["variational"]:
        kept = "have left that as it is" if found["symplectic"] else "need not keep areas"
        said += f"; the forces besides those of L {kept}"
    if found["failed"]:
        said += f"; {found['failed']} more could not be made"
    return [said]


def _least_action(found: dict, time: str) -> list[str]:
    said = f"least_action: {found['action']:.12g} over {found['time']:.6g}"
    said += f"{_in(time)}, stationary to {found['slope']:.0e}; "
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
    more = found["index"] - len(found["conjugate"])
    if more > 0 and len(found["conjugate"]) < CONJUGATE_SHOWN:
        said += f"; {more} more by points that count twice, where the determinant keeps its sign"
    return [said]


def _action(found: dict, time: str) -> list[str]:
    if found["action"] is None:
        return [f"action: {found['orbit']}"]
    said = f"action: {found['orbit']}"
    if found["lo"] is not None:
        said += f" between {found['lo']:.10g} and {found['hi']:.10g}"
    said += f": J = {found['action']:.12g}, period {found['period']:.12g}{_in(time)}"
    said += f" (relative error {found['error']:.0e})"
    said += ", with t and any inputs held at the start" if found["held"] else ""
    lines = [said]
    drift = found.get("drift")
    if drift and drift["max"] is not None:
        (line,) = drift_lines([drift])
        lines.append(f"action: over {len(found['rows'])} rows {line}")
        if found["changes"]:
            lines[-1] += f"; then, at t = {found['rows'][-1][0]:.6g}, it is {found['changes']}"
        if found["of_forces"]:
            lines[-1] += "; J is that of L alone, which other forces may change"
    return lines


def _places(found: dict) -> str:
    """Names the particles of a result, and the part of L that belongs to no particle."""
    places = found["places"]
    said = ", ".join(places[:4]) + (f" and {len(places) - 4} more" if places[4:] else "")
    return said + (f" ({found['beyond']})" if found["beyond"] else "")


def _angular_momentum(found: dict, time: str) -> list[str]:
    said = [f"angular momentum of the particles at {_places(found)}"]
    for about in ("origin", "centre"):
        of = found[about]
        if of is None:
            continue
        place = "the origin" if about == "origin" else "the centre of mass"
        lines = drift_lines(of["drifts"])
        what = "its torque is round-off: this is drift"
        if of["torque"] > NO_TORQUE:
            what = "the model does not conserve it (there is a torque): this is how it varies"
        axes = [["L_x", "L_y", "L_z"].index(drift["name"]) for drift in of["drifts"]]
        first = ", ".join(f"{of['first'][axis]:.10g}" for axis in axes)
        said.append(f"angular momentum about {place}: {first} at the start; {what}")
        said += [f"angular momentum about {place}: {line}" for line in lines]
    return said


def _lrl(found: dict, time: str) -> list[str]:
    said = f"lrl of {_places(found)}: eccentricity {found['eccentricity']:.10g} at the start"
    if found["varies"] > NO_TORQUE:
        said += "; the force is not as 1/r^2: the model does not conserve its vector"
    lines = [said, f"lrl: {drift_lines([found['drift']])[0]}"]
    if found["turned"] is None:
        return [
            *lines,
            "lrl: at the start it is that of a circle, without a pericentre that could turn",
        ]
    turned = f"lrl: it has turned by {found['turned']:.6g}, {found['rate']:.6g}{_per(time)}"
    if found["per_period"] is not None:
        turned += (
            f"; from pericentre to pericentre, {found['period']:.10g}{_in(time)}, "
            f"by {found['per_period']:.8g}"
        )
    return [*lines, turned]


def _modes(found: dict, time: str) -> list[str]:
    squares = found["squares"]
    leaving = [math.sqrt(-x) for x in squares if x < 0]  # in ascending order
    growths = found.get("growths", ())  # of an equilibrium whose modes have no energies
    swings = [f for f in found["frequencies"] if f or (f is not None and not growths)]
    said = []
    if leaving:
        rates = _few([f"{rate:.10g}" for rate in leaving], _per(time))
        said.append(
            "modes: about an unstable equilibrium, in which the motion starts, or no stable one "
            f"below its energy was found: {len(leaving)} of {found['modes']} modes leave it, at "
            f"the rate {rates}; energies of these tell little"
        )
    if swings:
        said.append(f"modes: {_few([f'{f:.10g}' for f in swings], _in(time, 'rad/'))}")
    if decays := [f"{-x:.10g}" for x in growths if x < 0]:
        said.append(f"modes: {_few(decays, _per(time))} decay")
    if growths and not said:
        said.append("modes: neutral")
    if not found["rows"]:
        return said
    for name, row in (("start", found["rows"][0]), ("end", found["rows"][-1])):
        total, *energies = row[1], *row[3:]
        order = sorted(range(len(energies)), key=lambda k: -abs(energies[k]))[:3]
        parts = ", ".join(f"{energies[k]:.6g} in mode {k + 1}" for k in order)
        said.append(
            f"modes: at the {name} {total:.6g} in all modes, {parts}; nonlinear {row[2]:.3g}"
        )
    return said


def _area(found: dict, time: str) -> list[str]:
    rows, until = found["rows"], found["resolved_until"]
    said = f"area: {rows[0][1]:.12g} within {found['members']} members at the start; "
    if found["ends"] is None:
        said += "resolved to the end"
    elif until == rows[-1][0]:
        said += f"resolved until t = {until:.6g}{_in(time)}, as far as all members come"
    else:
        said += f"resolved until t = {until:.6g}{_in(time)}, later {found['ends']}"
    if not found["conserved"]:
        said += "; with states, or forces besides those of L, it need not be conserved"
    if found["drift"] is None:
        return [said]
    lines = [said, f"area: while resolved {drift_lines([found['drift']])[0]}"]
    noisy = [row for row in rows if row[0] <= until and row[2] > found["threshold"]]
    if noisy:
        noise = max(row[3] for row in noisy) / found["drift"]["scale"]
        lines[-1] += f"; errors of each member's own may be {noise:.0e} of that"
    return lines


_TEXTS = {
    "area": _area,
    "modes": _modes,
    "angular_momentum": _angular_momentum,
    "lrl": _lrl,
    "action": _action,
    "lyapunov": _lyapunov,
    "reversal": _reversal,
    "spectrum": _spectrum,
    "symplectic": _symplectic,
    "least_action": _least_action,
}
