"""The table of scalar functions of the language: one row per function, for all stages.

To add a function, add a row to `smooth.py` or `kinked.py`; `row.py` explains the fields. The
functions in a row get a graph, balls or polynomials as arguments, so rows import no compiler code.
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

SIDE = "side_"  # prefix of C functions with an argument `side` (back/c/helpers.py)
WRITTEN_OUT = {"ln": 1, "clamp": 3}  # numbers of arguments; become log(x), min(max(x, a), b)
# Foreign names, for hints in messages.
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
