"""The scalar functions of the language, one row each: what check, derive and render must know.

The derivative of each is in `differentiate.py`. `c` is the <math.h> function, or if it starts
with a colon a helper that `back/c/templates/helpers.j2` defines (`:step` is NAME_step). All helpers
hand a NaN on.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Function:
    """`units`: "none" takes and gives dimensionless; "same" takes one dimension, gives it back;
    "any" takes one dimension, gives none; "root" halves the dimension."""

    arity: int
    units: str
    c: str
    smooth: bool = True
    internal: bool = False  # made by differentiation, not available in a model


FUNCTIONS: dict[str, Function] = {
    "sin": Function(1, "none", "sin"),
    "cos": Function(1, "none", "cos"),
    "tan": Function(1, "none", "tan"),
    "asin": Function(1, "none", "asin"),
    "acos": Function(1, "none", "acos"),
    "atan": Function(1, "none", "atan"),
    "atan2": Function(2, "any", "atan2"),
    "sinh": Function(1, "none", "sinh"),
    "cosh": Function(1, "none", "cosh"),
    "tanh": Function(1, "none", "tanh"),
    "exp": Function(1, "none", "exp"),
    "log": Function(1, "none", "log"),
    "sqrt": Function(1, "root", "sqrt"),  # derivative 0 at 0
    "abs": Function(1, "same", "fabs", smooth=False),
    "min": Function(2, "same", ":min", smooth=False),
    "max": Function(2, "same", ":max", smooth=False),
    "step": Function(1, "any", ":step", smooth=False),  # 0 below 0, 1 from 0 on
    # a to a power that is not a constant
    "pow": Function(2, "none", "pow", internal=True),
    "sign": Function(1, "any", ":sign", smooth=False),  # -1, 0 or 1: the derivative of abs
    # 1/x, and 0 at 0: with it sqrt, norm and abs have derivative 0 at 0
    "reciprocal": Function(1, "any", ":reciprocal", internal=True),
}

# In C alone: the same with the side of their switch in front, not 0 while a run has it located.
IN_C = FUNCTIONS | {
    "side_step": Function(2, "any", ":side_step", smooth=False, internal=True),
    "side_sign": Function(2, "any", ":side_sign", smooth=False, internal=True),
    "side_abs": Function(2, "any", ":side_abs", smooth=False, internal=True),
    "side_min": Function(3, "any", ":side_min", smooth=False, internal=True),
    "side_max": Function(3, "any", ":side_max", smooth=False, internal=True),
}

WRITTEN_OUT = {"ln": 1, "clamp": 3}  # log(x) and min(max(x, a), b) from the checker on: arguments
# What others call them.
MEANT = {
    **dict.fromkeys(("heaviside", "Heaviside", "theta", "Theta", "H"), "step"),
    **dict.fromkeys(("sgn", "signum"), "sign"),
    **{"fabs": "abs", "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2"},
}

ODD = frozenset({"sin", "tan", "asin", "atan", "sinh", "tanh", "sign", "reciprocal"})
EVEN = frozenset({"cos", "cosh", "abs"})

VECTOR_FUNCTIONS = {"dot": 2, "cross": 2, "norm": 1}  # and `rot`, of front/check/vectors.py
