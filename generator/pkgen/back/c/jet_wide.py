"""The Taylor coefficients of several states at once, in vectors: see pk/step/wide.h."""

from __future__ import annotations

import re
from collections.abc import Mapping

from .ctext import fold

_BEFORE = """\
#undef PK_JET_ADD
#undef PK_JET_MIDDLE_1
#undef PK_JET_HALF_1
#define PK_JET_ADD(a, b, c) pk_wide_add(a, b, c)
#define PK_JET_MIDDLE_1(a, b) pk_wide_of(0)
#define PK_JET_HALF_1(a) pk_wide_of(0)
"""
_HEAD = """\
static unsigned {}_jet_wide(size_t W, const pk_real *P, const pk_real *at, const pk_real *x,
                            int order, pk_real *PK_RESTRICT c)
"""


class Wide:
    """Translates lines of jets.jet(). `own` is the number of coordinates; `places` maps the members
    of the params to their index."""

    def __init__(self, own: int, places: Mapping[str, int]):
        self.own, self.places = own, places
        self.used: dict[str, str] = {}  # C text of a member -> the name of its vector

    def line(self, text: str) -> str:
        if text.startswith(("(void)p", "if (order < 1")):
            return ""
        if text.startswith("if (order =="):
            return "if (order == pk_k1) return pk_wide_mask(bad);"
        if found := re.fullmatch(r"const pk_real ([qv])(\d+)_0 = [qv]\[\d+\];", text):
            row = int(found[2]) + (self.own if found[1] == "v" else 0)
            return f"const pk_wide {found[1]}{found[2]}_0 = pk_wide_at(x + {row} * W);"
        if found := re.fullmatch(r"c\[(.*)\] = (\w.*);", text):
            return f"pk_wide_put(c + ({found[1]}) * W, {found[2]});"
        text = re.sub(r"p->([\w\[\].]+)", self._member, text)
        if found := re.fullmatch(r"if \(!\((.*)\)\) return PK_FAILED.*", text):
            return f"bad |= ~({found[1]});"
        text = re.sub(r"PK_F\((\w+)\)\(", r"pk_wide_\1(", text).replace("pk_real", "pk_wide")
        number = re.fullmatch(r"(const pk_wide \w+(?:##\w+)? = )([^a-zA-Z]+|pk_k == 1);", text)
        return f"{number[1]}pk_wide_of({number[2]});" if number else text

    def _member(self, found: re.Match[str]) -> str:
        return self.used.setdefault(found[1], f"p_{len(self.used)}")

    def loads(self) -> list[str]:
        of = self.used.items()
        return [f"const pk_wide {x} = pk_wide_at(P + {self.places[m]} * W);" for m, x in of]


def wide(name: str, of: Wide, first: list[str], start: str, later: str, orders: int) -> str:
    """Returns the C of NAME_jet_wide. `start` and `later` are the macros of the steps, translated;
    the params, states and coefficients of neighbouring states are neighbours, W numbers a row."""
    lines = [x for x in map(of.line, first) if x]
    body = [
        "const pk_wide t = pk_wide_at(at);",
        "pk_wide_bits bad = {0};",
        *of.loads(),
        *lines,
        "(void)P, (void)t;",
        f"{name}_JET_WIDE_0(0, 1)",
        *(f"{name}_JET_WIDE({k}, {k + 1})" for k in range(1, orders)),
        "return pk_wide_mask(bad);",
    ]
    text = "\n".join(fold(line, 4) for line in body)
    return f"{_BEFORE}{start}{later}{_HEAD.format(name)}{{\n{text}\n}}\n#undef PK_JET_ADD\n"
