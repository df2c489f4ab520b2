"""The methods of the runtime as a text table; `--json` prints the same data as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..methods import METHODS
from ..own.trees import MOST_ORDER
from ..system.columns import aligned

SOME = 5  # at most this many methods are named for each use

_COLUMNS = "method,order,stages,symplectic,symmetric,step,h omega,h lambda,requires"
HEADER = tuple(_COLUMNS.split(","))
NOTE = """\
h omega   limit below which the steps of an oscillation q'' = -omega^2 q do not grow
h lambda  the same of a decay q'' = -lambda q'
          none: all steps grow; any: none does; -: no answer, since the order of taylor varies,
          adaptive_verlet takes no damping and GSL keeps its tables. Adaptive methods: of
          their formula at a fixed step; respa: where nothing is fast.
"""


# For each family, in the order of the table: when to use its methods.
USES = {
    "GAUSS": "smooth motions, to any accuracy (the default)",
    "TAYLOR": "smooth motions, at tight tolerances",
    "EMBEDDED": "motions with kinks, or of many coordinates",
    "RADAU": "stiff or strongly damped motions",
    "EXPONENTIAL": "linear models, exactly",
    "SPLITTING": "long runs of particles: M constant, V of q alone",
    "ADAPTIVE_VERLET": "the same with close encounters",
    "BORIS": "the same with magnetic forces",
    "RESPA": "the same with fast forces beside slow ones",
    "COLLOCATION": "long runs of any L; radau5, radau9: stiff",
    "RATTLE": "long runs with constraints or rotations",
    "LIE_MIDPOINT": "long runs with rotations",
    "LANGEVIN": "noise and friction, M constant",
    "HEUN": "noise, any model",
    "RKMK": "rotations, few steps",
    "ERK": "fixed steps at the lowest cost each",
    "GSL": "comparison with GSL",
}

WORDS = {
    "linear drag": "separable but for linear drag",
    "series": "expandable in Taylor series",
    "fast": "of which a part is named fast",
    "affine rates": "of constant M, its forces affine in the rates",
}


def methods_text(found: Sequence[Mapping[str, Any]]) -> str:
    """Returns a text: for each use, such as stiff equations, the methods that suit it; then a table
    of all methods, with references."""
    named = {str(m["name"]): m for m in found}
    uses = {use: [n for n in named if METHODS[n].family == of] for of, use in USES.items()}
    uses = {use: names for use, names in uses.items() if names}
    rows = [HEADER, *(_row(named[n]) for names in uses.values() for n in names)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(HEADER))]
    table = aligned([rows[0], ["-" * w for w in widths], *rows[1:]])
    lines = aligned([(use, _some(names)) for use, names in uses.items()])
    docs = aligned([(n, str(named[n]["doc"])) for names in uses.values() for n in names])
    return "\n".join([*lines, "", *table, "", NOTE, *docs])


def _some(names: Sequence[str]) -> str:
    return ", ".join(names if len(names) <= SOME else [*names[:SOME], f"{len(names) - SOME} more"])


def own_text(found: Sequence[Mapping[str, Any]]) -> str:
    """Returns a paragraph for each of the model's own methods."""
    return "\n\n".join(_paragraph(m) for m in found)


def _paragraph(m: Mapping[str, Any]) -> str:
    lines = dict(m["facts"])
    if m["runs"]:
        lines |= {
            "h omega": _limit(m["limits"]["imaginary"]),
            "h lambda": _limit(m["limits"]["real"]),
            "step": "adaptive" if "adaptive" in m["flags"] else "fixed",
            "requires": ", ".join(in_words(m["requires"])) or "nothing",
        }
    else:
        lines["runs"] = "no: of tables the explicit ones run"
    width = max(map(len, lines))
    rows = (f"  {key:<{width}}  {_said(key, x)}" for key, x in lines.items())
    return "\n".join([str(m["name"]), *rows])


def _said(key: str, value: object) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if key.endswith("order") and value == MOST_ORDER:
        return f"{value} or more"
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def in_words(requires: Iterable[str]) -> list[str]:
    """Returns in words the properties of a system that a method requires."""
    found = [fact.replace("_", " ") for fact in requires]
    found = [WORDS.get(fact, fact) for fact in found]
    if found[1:]:  # other requirements imply "mass constant"
        found = [fact for fact in found if fact != "mass constant"]
    return found


def _row(m: Mapping[str, Any]) -> tuple[str, ...]:
    flags = set(m["flags"])
    requires = in_words(m["requires"])
    requires += ["da/dq, da/dv"] if "linear" in flags else []
    requires += ["no inputs"] if "no_inputs" in flags else []
    return (
        str(m["name"]),
        str(m["order"]) if m["order"] else "exact" if "exact" in flags else "varies",
        str(m["stages"]) if m["stages"] else "none" if "exact" in flags else "varies",
        "yes" if "symplectic" in flags else "",
        "yes" if "symmetric" in flags else "",
        "adaptive" if "adaptive" in flags else "fixed",
        _limit(m["limits"]["imaginary"]),
        _limit(m["limits"]["real"]),
        ", ".join(requires),
    )


def _limit(value: float | str | None) -> str:
    if value is None:
        return "-"
    if value == "infinite":
        return "any"
    return f"{value:.8g}" if float(value) > 0 else "none"
