"""Writes the C code of user-defined methods: a header with their coefficients, and definitions of
the methods that have the form of those in pk/methods.h.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..methods import Own

FILE = "own_methods.h"  # Name of the generated header.


def tables(own: Sequence[Own]) -> str:
    return "".join(["#include <pk/step/tableau.h>\n", *(method.table for method in own)])


def flags(own: Sequence[Own]) -> list[str]:
    """Returns the compiler flags with which pk/step/tables.h includes the generated header."""
    return ["-I.", f'-DPK_OWN_TABLES="{FILE}"'] if own else []


def definitions(own: Sequence[Own]) -> str:
    lines = ["#include <pk/families.h>", "#include <pk/step/tables.h>"] if own else []
    for method in own:
        lines += [f"extern const struct pk_method pk_method_{method.name};", method.row]
    return "".join(f"{line}\n" for line in lines)


def addresses(own: Sequence[Own]) -> str:
    return ", ".join(f"&pk_method_{method.name}" for method in own)


def rows(own: Sequence[Own]) -> str:
    """Returns C code: definitions of the methods, and an array `own_methods` with pointers to them.
    Returns "" if there are no methods."""
    array = f"static const struct pk_method *own_methods[] = {{{addresses(own)}}};\n"
    return definitions(own) + array if own else ""
