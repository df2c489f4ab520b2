"""Own methods in C: a header of their tables, and rows as pk/methods.h has those of the runtime."""

from __future__ import annotations

from collections.abc import Sequence

from ..methods import Own

FILE = "own_methods.h"  # of the tables


def tables(own: Sequence[Own]) -> str:
    return "".join(["#include <pk/step/tableau.h>\n", *(method.table for method in own)])


def flags(own: Sequence[Own]) -> list[str]:
    """By which pk/step/tables.h has them."""
    return ["-I.", f'-DPK_OWN_TABLES="{FILE}"'] if own else []


def rows(own: Sequence[Own]) -> str:
    """An array `own_methods`; nothing where there are none."""
    if not own:
        return ""
    lines = ["#include <pk/families.h>", "#include <pk/step/tables.h>"]
    for method in own:
        lines += [f"extern const struct pk_method pk_method_{method.name};", method.row]
    named = ", ".join(f"&pk_method_{method.name}" for method in own)
    lines.append(f"static const struct pk_method *own_methods[] = {{{named}}};")
    return "\n".join(lines) + "\n"
