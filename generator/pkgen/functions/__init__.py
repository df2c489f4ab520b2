"""The scalar functions of the language, one row each: what every stage knows about them.

A new function is a row of `smooth.py` or `kinked.py`; `row.py` says what the fields mean. Rows are
called with what they work on (a graph, balls, polynomials), so they import nothing of the compiler.
"""

from __future__ import annotations

from .kinked import KINKED
from .row import Function
from .smooth import SMOOTH

FUNCTIONS: dict[str, Function] = {
    **{name: row for name, row in SMOOTH.items() if not row.internal},
    **KINKED,
    **{name: row for name, row in SMOOTH.items() if row.internal},
}

SIDE = "side_"  # before the name of a function that C is told the side of
WRITTEN_OUT = {"ln": 1, "clamp": 3}  # log(x) and min(max(x, a), b) from the checker on: arguments
# What others call them.
MEANT = {
    **dict.fromkeys(("heaviside", "Heaviside", "theta", "Theta", "H"), "step"),
    **dict.fromkeys(("sgn", "signum"), "sign"),
    **{"fabs": "abs", "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2"},
}

VECTOR_FUNCTIONS = {"dot": 2, "cross": 2, "norm": 1}  # and `rot`, of front/check/vectors.py

__all__ = [
    "FUNCTIONS",
    "MEANT",
    "SIDE",
    "VECTOR_FUNCTIONS",
    "WRITTEN_OUT",
    "Function",
]
