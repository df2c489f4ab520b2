"""Writes the C of `struct unit_model` (c/unit.h): integration methods, defaults and token."""

from __future__ import annotations

from pkgen.back.exported import Exported

TEXT = """/* The unit's methods and defaults. */
#include "unit.h"

{declared}
static const struct pk_method *const methods[] = {{{addresses}}};

const struct unit_model unit_model = {{
    "{token}", methods, {n_methods}, {method}, {step!r}, {rtol!r}}};
"""


def model_c(model: Exported, token: str) -> str:
    known = [m["name"] for m in model.methods()]
    run = model.description["run"]
    return TEXT.format(
        declared="".join(f"extern const struct pk_method pk_method_{m};\n" for m in known),
        addresses=", ".join(f"&pk_method_{m}" for m in known),
        token=token,
        n_methods=len(known),
        method=known.index(model.method()),
        step=float(run["step"] or 0),
        rtol=float(run["rtol"]),
    )
