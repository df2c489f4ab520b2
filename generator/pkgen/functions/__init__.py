"""The table of scalar functions of the language: one row per function, for all compiler stages.

To add a function, add a row to `smooth.py`, `elliptic.py` or `kinked.py`; `row.py` explains the
fields. The functions in a row get the compiler's objects that they use (such as the graph) as
arguments, so that rows import no compiler code.
"""

from __future__ import annotations

import weakref
from weakref import WeakValueDictionary

from . import tables
from .elliptic import ELLIPTIC
from .kinked import KINKED
from .row import Function
from .smooth import SMOOTH

FUNCTIONS: dict[str, Function] = {
    **{name: row for name, row in SMOOTH.items() if not row.internal},
    **ELLIPTIC,
    **KINKED,
    **{name: row for name, row in SMOOTH.items() if row.internal},
}


_TABLES: WeakValueDictionary[str, tables.Data] = WeakValueDictionary()


def add_table(name: str, key: str, data: tables.Data) -> tables.Data:
    """Adds the rows of a model's table, for as long as the model is there. Returns the data that
    the rows have: those of an earlier table with the same key, which are equal."""
    if key not in _TABLES:
        _TABLES[key] = data
        added = tables.rows(name, key, weakref.proxy(data))
        FUNCTIONS.update(added)
        weakref.finalize(data, lambda: [FUNCTIONS.pop(name) for name in added])
    return _TABLES[key]


# The prefix of C functions with an argument `side` (back/c/helpers.py).
SIDE = "side_"
# Functions that front/check/calls.py writes out: the number of their arguments a, b, c, and their
# text. It writes min and max of more than two arguments out too.
WRITTEN_OUT = {
    "ln": (1, "log(a)"),
    "clamp": (3, "min(max(a, b), c)"),
    "ceil": (1, "-floor(-a)"),
    "round": (1, "floor(a + 0.5)"),
    "mod": (2, "a - b*floor(a/b)"),
    "sn": (2, "sin(am(a, b))"),
    "cn": (2, "cos(am(a, b))"),
    "dn": (2, "sqrt(cos(am(a, b))^2 + (1 - b)*sin(am(a, b))^2)"),  # no digits cancel
}
# Maps names that other languages give to functions to the names in this language. Error messages
# suggest the name in this language.
MEANT = {
    **dict.fromkeys(("heaviside", "Heaviside", "theta", "Theta", "H"), "step"),
    **dict.fromkeys(("sgn", "signum"), "sign"),
    **{"fabs": "abs", "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2"},
}

# The number of arguments of each vector function except `rot`, which is in front/check/vectors.py.
VECTOR_FUNCTIONS = {"dot": 2, "cross": 2, "norm": 1}
