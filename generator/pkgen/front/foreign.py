"""Statements, functions, names and characters of other languages, each with a hint for users."""

from __future__ import annotations

import re

_RATE = "a rate is written x', and x'' where outputs may have accelerations"
_MOTION = "pkgen derives the motion: write 'kinetic …', 'potential …' and 'force x = …'"
_FIRST_ORDER = f"{_RATE}; for x' = f(x) write 'state x' and 'rate x = …'"
STEP = "if(x > 0, a, b) is a where x > 0, else b; max(0, x), min, abs and clamp bend"
_LATEX = r"\frac{a}{b} is a/b, \dot{x} is x', \theta is theta"

# Pattern of the first words of a statement, and its hint.
_STATEMENTS = tuple(
    (re.compile(pattern), help)
    for pattern, help in (
        (r"(d\w*|∂\w*)\s*/\s*d?t\b|\w+'\s*=", _FIRST_ORDER),
        (r"(\w+\s*\*\s*)?\w+(''|\.\.)\s*[=+-]", _MOTION),
        (r"(eq|eqn|equations?|ode|dynamics)\b", _MOTION),
        (r"(der|diff|dot|Derivative)\s*\(", _FIRST_ORDER),
        (r"(ddot|dder|ddiff)\s*\(", _MOTION),
        (r"(import|from|include|using|use|require|package|library)\b",
         "a model imports nothing: pi, sin, cos, exp, … are there"),
        (r"(for|while|foreach|do)\b",
         "a sum over members is sum(m/2*q[i]'^2, i = 1..N), with 'size N = 3' and 'coord q[1..N]'"),
        (r"(if|else|elif|when|switch)\b", STEP),
        (r"(def|function|fun|lambda|func)\b", "a name for an expression: let y = -l*cos(theta)"),
        (r"(var|variables?|Real|real|double|float|int|Integer|dof|syms|symbols|generalized)\b",
         "write 'coord x [m]' for a coordinate, 'param m = 1 [kg]' for a parameter"),
        (r"(const|constant)s?\s+(double|float|int)\b",
         "write 'const c = 3' or 'param g = 9.81 [m/s^2]'"),
        (r"(damping|damper|viscous|rayleigh)\b",
         "write 'dissipation b/2*x'^2', or 'force x = -b*x''"),
        (r"(spring|stiffness)\b", "write 'potential k/2*x^2'"),
        (r"(initial|init|ic|ics|x0|y0)\b", "write 'start x = 1, x' = 0'"),
        (r"\w+\s*\(\s*0\s*\)\s*=", "write 'start x = 1, x' = 0'"),
        (r"(output|outputs|print|plot|display|show|return)\b",
         "write 'observe NAME = …'; a run's columns are chosen by --record"),
        (r"(solve|simulate|integrate|run|tspan|tstop|StopTime)\b",
         "the command 'pkgen run' integrates; in a scene write 'until 10' and 'method gauss'"),
        (r"(mass|masses|body_mass)\b", "write 'param m = 1 [kg] in (0, inf)'"),
        (r"(energy|hamiltonian|H)\b", "write 'kinetic …' and 'potential …', or 'lagrangian …'"),
        (r"(class|record|begin|end_model)\b", "the first line is 'model NAME'; nothing closes it"),
        (r"(//|/\*|--|;)", "a comment begins with #"),
    )
)  # fmt: skip
# Functions of other languages.
FUNCTIONS = {
    **dict.fromkeys(("diff", "der", "ddt", "D", "Derivative", "deriv"), _RATE),
    **dict.fromkeys(("ddot", "dder"), _RATE),
    "pow": "x to the power of y is x^y",
    **dict.fromkeys(("piecewise", "Piecewise"), STEP),
}
NAMES = {"e": "e^x is exp(x)", "Pi": "write pi", "PI": "write pi", "M_PI": "write pi"}
CHARACTERS = {
    ";": "a statement ends with its line",
    "|": "the absolute value is abs(x)",
    "?": STEP,
    "%": "a comment begins with #",
    "\\": _LATEX,
    "!": "a comment begins with #",
    '"': "a name needs no quotes",
    "&": "a product is written a*b",
    "@": "an event is 'event hit: y falling stop'",
    "$": _LATEX,
}


def statement(text: str) -> str:
    """Returns the hint for a statement of another language that begins like `text`, or ""."""
    return next((help for pattern, help in _STATEMENTS if pattern.match(text)), "")
