"""C functions that <math.h> lacks, from the table of functions."""

from __future__ import annotations

from collections.abc import Iterable

from ...functions import FUNCTIONS, SIDE


def helper_name(function: str) -> str:
    """Returns the C name of a function that <math.h> lacks, without the model's name in front.
    NAME_step is a step of the motion in an export."""
    return "unit_step" if function == "step" else function


def helpers(names: Iterable[str]) -> list[dict[str, str]]:
    """Returns the functions that the template helpers.j2 writes: first plain functions in the order
    of FUNCTIONS, then functions with an additional argument `side`, the sign of a switch."""
    names = set(names)
    plain = [
        _helper(helper_name(name), row.arguments, row.body, row.note, row.remark, row.steps)
        for name, row in FUNCTIONS.items()
        if name in names
    ]
    return plain + [_sided(name) for name in FUNCTIONS if SIDE + name in names]


def _helper(
    name: str, arguments: Iterable[str], body: str, note: str, remark: str = "", steps: str = ""
) -> dict:
    typed = ", ".join(f"pk_real {x}" for x in arguments)
    made = {"name": name, "arguments": typed, "body": body, "note": note, "remark": remark}
    return made | {"steps": steps}


def _sided(name: str) -> dict[str, str]:
    """Returns a function with an additional argument `side`. If `side` is not 0, the sign of `side`
    selects one of the function's two smooth branches."""
    row = FUNCTIONS[name]
    sides = row.kinked or row.cut
    assert sides is not None
    free = row.body or f"PK_F({row.c or name})({', '.join(row.arguments)})"
    if row.kinked and row.kinked.held:
        body = f"side > 0 || side < 0 ? {row.kinked.held} : {free}"
        return _helper(
            SIDE + name, ("side", *row.arguments), body, "`side`: 2 n + 1 between n and n + 1."
        )
    body = f"side > 0 ? {sides.above} : side < 0 ? {sides.below} : {free}"
    note = f"`side`: that of {' - '.join(row.arguments)}." if row.arity > 1 else ""
    return _helper(SIDE + name, ("side", *row.arguments), body, note)
