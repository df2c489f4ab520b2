"""Makes the list of a unit's FMI variables from the description of a model."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from pkgen.back.exported import Exported
from pkgen.back.host.data import states
from pkgen.record import record

SHIFT = 20  # must equal UNIT_SHIFT of c/unit.h
_KINDS = "time parameter input slope state rate output energy claim indicator setting"
KINDS = {kind: k for k, kind in enumerate(re.split(" ", _KINDS))}
METHOD, STEP, RTOL = range(3)


@record
class Variable:
    """An FMI variable. `start` is None if the variable is computed. If the variable is a time
    derivative, `derivative` is the value reference of the variable of which it is the
    derivative."""

    name: str
    reference: int
    causality: str
    start: float | int | None = None
    unit: str = ""
    description: str = ""
    lo: float | None = None
    hi: float | None = None
    derivative: int | None = None
    fixed: bool = False  # cannot change after initialization
    kind: str = ""


def reference(kind: str, index: int) -> int:
    return KINDS[kind] << SHIFT | index


Described = Mapping[str, Any]


def variables(exported: Exported) -> list[Variable]:
    return list(_variables(exported))


def _variables(exported: Exported) -> Iterator[Variable]:
    model = exported.description
    taken = {p["name"] for p in model["parameters"]}
    time = "" if model["dimensionless"] else "s"
    name = next(word for word in ("time", "time_", "t") if word not in taken)
    yield Variable(name, 0, "independent", unit=time)
    for k, p in enumerate(model["parameters"]):
        about = {"lo": p["lo"], "hi": p["hi"]}
        yield Variable(
            p["name"], reference("parameter", k), "parameter", p["value"], p["unit"],
            p["description"], **about,
        )  # fmt: skip
    for k, u in enumerate(model["inputs"]):
        about = u["description"]
        yield Variable(u["name"], reference("input", k), "input", u["value"], u["unit"], about)
        yield Variable(
            f"der({u['name']})", reference("slope", k), "input", 0.0, over(u["unit"], time),
            f"slope of {u['name']} between communication points", kind="slope",
        )  # fmt: skip
    x = states(model)
    for k, s in enumerate(x):
        yield Variable(
            s["name"], reference("state", k), "output", s["value"] or 0.0, s["unit"], _about(s)
        )  # fmt: skip
    for k, s in enumerate(x):
        yield Variable(
            f"der({s['name']})", reference("rate", k), "local", None, over(s["unit"], time),
            derivative=reference("state", k),
        )  # fmt: skip
    for o in model["outputs"]:
        yield Variable(
            o["name"], reference("output", o["index"]), "output", None, o["unit"], o["description"]
        )
    for c in model["constants"]:
        if c["kind"] in ("energy", "claim"):
            about = c.get("label", "constant along every motion")
            yield Variable(
                c["name"], reference(c["kind"], c["index"]), "output", None, c["unit"], about
            )
    for k, name in enumerate(indicators(model)):
        yield Variable(name, reference("indicator", k), "local", kind="indicator")
    default = [m["name"] for m in exported.methods()].index(exported.method()) + 1
    run = model["run"]
    yield Variable(
        "integrator.method", reference("setting", METHOD), "parameter", default,
        description="of co-simulation", fixed=True, kind="method",
    )  # fmt: skip
    yield Variable(
        "integrator.step", reference("setting", STEP), "parameter", run["step"] or 0.0, time,
        "0: an adaptive method chooses, others take the communication step", 0.0, fixed=True,
    )  # fmt: skip
    yield Variable(
        "integrator.rtol", reference("setting", RTOL), "parameter", run["rtol"],
        description="of adaptive methods; of states bound in model exchange", lo=0.0, hi=1.0,
        fixed=True,
    )  # fmt: skip


def _about(state: Described) -> str:
    text = state["description"]
    return {"rate": text and f"rate: {text}", "body rate": "body rate"}.get(state["kind"], text)


def indicators(model: Described) -> list[str]:
    """Returns the names of the event indicators: events, then switches of the equations."""
    events = [f"event({e['name']})" for e in model["events"]]
    return events + [f"switch({k + 1})" for k in range(model["switches"])]


def over(unit: str, time: str) -> str:
    """Returns the unit of the time derivative of a quantity in `unit`."""
    return f"{unit or '1'}/{time}" if time else unit
