"""Collects the C files of the interface pk_host.h, and writes a model's data for it as C."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...methods import Own
from ...own import in_c
from ...system.exits import UsageError

HERE = Path(__file__).parent
VALUES = ("pk_host.h", "pk_host.c")
MOTIONS = (*VALUES, "pk_host_motion.c")
DATA = "pk_host_model.c"
Described = Mapping[str, Any]
_TABLES = ("parameters", "inputs", "coordinates", "rates", "outputs", "events")
_TEXT = """/* The model as its hosts begin with it. */
#include <math.h>

#include "pk_host.h"

extern const struct pk_system {name}_system;
{own}
const struct pk_host_model pk_host_model = {{{entries}}};
"""


def interface(name: str, own: Sequence[Own], of: Described | None, files=MOTIONS) -> dict[str, str]:
    """Returns the C files of the interface to the model `name`, by path. `of` is the description of
    the model; if it is None, the files contain no default values and names."""
    found = {file: (HERE / file).read_text(encoding="utf-8") for file in files}
    return found | {DATA: data(name, own, of)}


def data(name: str, own: Sequence[Own], of: Described | None = None) -> str:
    entries = {"system": f"&{name}_system"}
    if of is not None:
        p, y = of["parameters"], states(of)
        entries |= {
            "parameters": _numbers(q["value"] for q in p),
            "lo": _numbers((q["lo"] for q in p), -math.inf),
            "hi": _numbers((q["hi"] for q in p), math.inf),
            "inputs": _numbers(u["value"] for u in of["inputs"]),
            "start": _numbers(q["value"] for q in y),
            "follows": _flags(q["follows"] for q in p),
            "start_follows": _flags(q["follows"] for q in y),
            "names": _array("char *const", (f'"{q["name"]}"' for q in p)),
            "n_parameters": str(len(p)),
        }
    if own:
        entries |= {"own": "own_methods", "n_own": str(len(own))}
    lines = "".join(f"\n    .{field} = {value}," for field, value in entries.items())
    return _TEXT.format(name=name, own=in_c.rows(own), entries=lines)


def states(of: Described) -> list[dict[str, Any]]:
    """Returns the states of a description, in the order of y: coordinates, rates, body rates, and
    first-order variables. Raises UsageError if the description lists only some of them."""
    if not of["whole"]:
        raise UsageError("the families are too long to be named one by one: take a smaller --size")
    coordinates = of["coordinates"]
    n_q = len(coordinates)
    keys = ("name", "unit", "description", "value", "follows", "kind")
    found: dict[int, tuple[Any, ...]] = {}
    for c in coordinates:
        k, about = c["index"], c["description"]
        found[k] = (c["name"], c["unit"], about, c["q"], c["q_follows"], "coordinate")
        found[n_q + k] = (c["rate"], c["rate_unit"], about, c["v"], c["v_follows"], "rate")
    for r in of["rotations"]:
        columns = (r[key] for key in ("rate_indices", "rates", "rate_values", "rates_follow"))
        for k, name, value, follows in zip(*columns, strict=True):
            found[n_q + k] = (name, r["rate_unit"], r["description"], value, follows, "body rate")
    for s in of["states"]:
        fields = [s[key] for key in keys[:-1]]
        found[n_q + s["index"]] = (*fields, "state")
    return [dict(zip(keys, found[k], strict=True)) for k in sorted(found)]


def tables(of: Described) -> dict[str, list[dict[str, Any]]]:
    """Returns for each kind (parameters, inputs, ...) the quantities that a host lists, in the
    order of their indices."""
    y, n_q = states(of), len(of["coordinates"])
    found = {**of, "coordinates": y[:n_q], "rates": y[n_q:]}
    return {kind: [q for q in found[kind] if not q.get("hidden")] for kind in _TABLES}


def _array(kind: str, items: Iterable[str]) -> str:
    return f"(const {kind}[]){{{', '.join(items) or '0'}}}"  # C has no empty arrays


def _flags(values: Iterable[bool]) -> str:
    return _array("unsigned char", (str(int(value)) for value in values))


def _numbers(values: Iterable[float | None], absent: float = math.nan) -> str:
    return _array("double", (_number(absent if value is None else value) for value in values))


def _number(value: float) -> str:
    if math.isnan(value):
        return "(double)NAN"
    return repr(float(value)).replace("inf", "HUGE_VAL")
