"""Extracts the coefficients of one method from the runtime's C tables, as `pk_NAME_table`."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable

from pkgen.back.c.render import pasted
from pkgen.methods import METHODS, Own

_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_STATEMENT = r"static const [^;]*?\bpk_{name}_(?:a|b|c|kick|drift|table)\b[^;]*;"
_VERLETS = r"PK_VERLETS\({name}, \d+, ((?:[^()]|\([^()]*\))*)\)"
_ROWS = r"PK_SPLITTING_TABLE\({name}, (\d+)\);"
_LIST = re.compile(r"PK_(MIRROR|TWICE)_\d+\(((?:[^()]|\([^()]*\))*)\)")


def table(name: str, own: Iterable[Own]) -> str:
    for method in own:
        if method.name == name:
            return method.table
    if METHODS[name].family == "ERK":
        text = _COMMENT.sub("", pasted("step/tables.h"))
        return "\n".join(re.findall(_STATEMENT.format(name=name), text)) + "\n"
    text = _COMMENT.sub("", pasted("step/tables_splitting.h"))
    steps = re.search(_VERLETS.format(name=name), text)
    if steps:
        drift = _mirrored(steps[1])
        first, last = f"({drift[0]}) / 2", f"({drift[-1]}) / 2"
        kick = [first, *(f"({a} + {b}) / 2" for a, b in itertools.pairwise(drift)), last]
        lists = [_array(name, "drift", drift), _array(name, "kick", kick)]
    else:
        found = re.findall(_STATEMENT.format(name=name), text)
        lists = [_LIST.sub(_unrolled, " ".join(statement.split())) for statement in found]
    stages = re.search(_ROWS.format(name=name), text)
    assert stages and len(lists) == 2, name
    entries = f"{stages[1]}, pk_{name}_kick, pk_{name}_drift"
    return "\n".join(
        [*lists, f"static const struct pk_splitting pk_{name}_table = {{{entries}}};\n"]
    )


def _words(text: str) -> list[str]:
    return [word.strip() for word in text.split(",")]


def _mirrored(text: str) -> list[str]:
    half = _words(text)
    return half + half[-2::-1]


def _unrolled(found: re.Match[str]) -> str:
    half = _words(found[2])
    return ", ".join(_mirrored(found[2]) if found[1] == "MIRROR" else half + half[::-1])


def _array(name: str, what: str, values: list[str]) -> str:
    rows = ",\n    ".join(values)
    return f"static const pk_real pk_{name}_{what}[] = {{\n    {rows}}};"
