"""How statements are written and tokens are called, for messages."""

from __future__ import annotations

from .table import STATEMENTS

# Of each clause which other comes after it, and how both are written.
ORDER = {
    "every": ("at", "record a, energy every 0.01 [s] at EVENT"),
    "step": ("rtol", "method dop853 step 0.01 [s] rtol 1e-9"),
    "within": ("at", STATEMENTS["expect"].form),
}
# What the parser may have wanted.
WHAT = {
    "EQUAL": "'='", "COLON": "':'", "DOTS": "'..'", "_COMMA": "','", "RPAREN": "')'",
    "RBRACKET": "']'", "NAME": "a name", "LEND": "'(' or '['", "REND": "')' or ']'",
}  # fmt: skip
