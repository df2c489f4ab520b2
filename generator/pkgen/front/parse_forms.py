"""How statements are written and tokens are called, for messages."""

from __future__ import annotations

# How each statement is written, for the hints.
FORMS = {
    "model": "model NAME",
    "param": "param NAME = VALUE [unit] in (lo, hi)",
    "size": "size NAME = INTEGER",
    "const": "const NAME = VALUE [unit]",
    "let": "let NAME = EXPRESSION",
    "observe": "observe NAME = EXPRESSION",
    "conserve": "conserve NAME = EXPRESSION",
    "rate": "rate NAME = EXPRESSION",
    "coord": "coord a, b [m], q[1..N] [rad]",
    "input": "input NAME [unit]",
    "state": "state NAME [unit]",
    "rotation": "rotation NAME",
    "fixed": "fixed q[0] = VALUE",
    "free": "free q",
    "periodic": "periodic q",
    "kinetic": "kinetic m/2*x'^2",
    "potential": "potential m*g*x",
    "lagrangian": "lagrangian m/2*x'^2 - m*g*x",
    "dissipation": "dissipation b/2*x'^2",
    "force": "force COORDINATE = EXPRESSION",
    "constraint": "constraint NAME: A = B",
    "rolling": "rolling NAME: A = B",
    "event": "event NAME: EXPRESSION rising",
    "start": "start a = VALUE, a' = VALUE",
    "scene": "scene NAME",
    "end": "end",
    "set": "set p = VALUE",
    "hold": "hold a = EXPRESSION",
    "until": "until 5 [s]",
    "accuracy": "accuracy 1e-9",
    "method": "method rk4 step 0.01 [s]",
    "record": "record a, energy every 0.01 [s]",
    "swarm": "swarm k = 1..1000",
    "expect": "expect A = B within 1e-6 at 2 [s]",
}
# Of each clause which other comes after it, and how both are written.
ORDER = {
    "every": ("at", "record a, energy every 0.01 [s] at EVENT"),
    "step": ("rtol", "method dop853 step 0.01 [s] rtol 1e-9"),
    "within": ("at", FORMS["expect"]),
}
# What the parser may have wanted.
WHAT = {
    "EQUAL": "'='", "COLON": "':'", "DOTS": "'..'", "_COMMA": "','", "RPAREN": "')'",
    "RBRACKET": "']'", "NAME": "a name", "LEND": "'(' or '['", "REND": "')' or ']'",
}  # fmt: skip
