"""Writes the wrapper's data of its model as C: `struct unit_model` of c/unit.h."""

from __future__ import annotations

import math
from collections.abc import Iterable

from pkgen.back.exported import Exported
from pkgen.own import in_c

from .variables import states

TEXT = """/* What the unit knows of its model. */
#include "{name}.h"

#include "unit.h"

#include <math.h>
{own}
{methods}
static const double parameters[] = {{{parameters}}};
static const double lo[] = {{{lo}}};
static const double hi[] = {{{hi}}};
static const unsigned char follows[] = {{{follows}}};
static const char *const names[] = {{{names}}};
static const double inputs[] = {{{inputs}}};
static const double start[] = {{{start}}};
static const unsigned char start_follows[] = {{{start_follows}}};
static const struct pk_method *const methods[] = {{{addresses}}};

const struct unit_model unit_model = {{
    &{name}_system, "{token}",
    parameters, lo, hi, inputs, start, follows, start_follows, names, {n_parameters},
    methods, {n_methods}, {method}, {step}, {rtol}}};
"""


def model_c(model: Exported, token: str) -> str:
    found = model.description
    known = [m["name"] for m in model.methods()]
    x, p = states(found), found["parameters"]
    own = {m.name for m in model.own}
    declared = "".join(
        f"extern const struct pk_method pk_method_{m};\n" for m in known if m not in own
    )
    run = found["run"]
    return TEXT.format(
        name=model.name,
        token=token,
        own=in_c.rows(model.own),
        methods=declared,
        parameters=_numbers(q["value"] for q in p),
        lo=_numbers((q["lo"] for q in p), -math.inf),
        hi=_numbers((q["hi"] for q in p), math.inf),
        follows=_row(str(int(q["follows"])) for q in p),
        names=_row(f'"{q["name"]}"' for q in p),
        inputs=_numbers(u["value"] for u in found["inputs"]),
        start=_numbers(s.start for s in x),
        start_follows=_row(str(int(s.follows)) for s in x),
        addresses=_row(f"&pk_method_{m}" for m in known),
        n_parameters=len(p),
        n_methods=len(known),
        method=known.index(model.method()),
        step=repr(float(run["step"] or 0)),
        rtol=repr(float(run["rtol"])),
    )


def _row(items: Iterable[str]) -> str:
    """Returns the items of a C initialiser; "0" if there are none, since C has no empty arrays."""
    return ", ".join(items) or "0"


def _numbers(values: Iterable[float | None], absent: float = math.nan) -> str:
    return _row(_number(absent if value is None else value) for value in values)


def _number(value: float) -> str:
    if math.isnan(value):
        return "NAN"
    return repr(float(value)).replace("inf", "HUGE_VAL")
