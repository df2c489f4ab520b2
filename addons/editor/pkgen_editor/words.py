"""The words of the modelling language by class, for colours and completion in an editor.

The words are from the tables of the lexer and the checker; descriptions of functions are here.
"""

from __future__ import annotations

from functools import cache

from pkgen.front.check.names import SPECIAL, callable_names
from pkgen.front.check.shared import ORIGIN
from pkgen.front.joints import CLAUSES, GROUND, KINDS, SHOWN, TO
from pkgen.front.shapes import FORMS, PLANES, SHAPES
from pkgen.front.table import STATEMENTS
from pkgen.front.words import BEHIND, CLAUSE_WORDS, CONSTANTS, TABLEAU
from pkgen.tree import COMPONENTS

_CALLS = """
sin(x)            the sine of an angle
cos(x)            the cosine of an angle
tan(x)            the tangent of an angle
asin(x)           the angle whose sine is x, from -pi/2 to pi/2
acos(x)           the angle whose cosine is x, from 0 to pi
atan(x)           the angle whose tangent is x, from -pi/2 to pi/2
atan2(y, x)       the angle of the point x, y, from -pi to pi
sinh(x)           the hyperbolic sine
cosh(x)           the hyperbolic cosine
tanh(x)           the hyperbolic tangent
exp(x)            e to the power x
log(x)            the natural logarithm
ln(x)             the natural logarithm: log(x)
sqrt(x)           the square root; half the dimension of x
abs(x)            the magnitude of a number; it bends at 0, where steps end
min(a, b)         the lesser; it bends where they are equal
max(a, b)         the greater; it bends where they are equal
step(x)           0 below 0, 1 from 0 on; it jumps there
sign(x)           -1, 0 or 1; it jumps at 0
clamp(x, a, b)    x within a and b: min(max(x, a), b)
floor(x)          the largest whole number up to x; it jumps, and steps end there
ceil(x)           the smallest whole number from x on
round(x)          the nearest whole number; halves go up
mod(a, b)         a - b*floor(a/b)
ellipk(m)         the complete elliptic integral K of the parameter m, the modulus squared
am(u, m)          Jacobi's amplitude; its m, up to 1, may not move
sn(u, m)          Jacobi's elliptic sine, sin(am(u, m))
cn(u, m)          Jacobi's elliptic cosine, cos(am(u, m))
dn(u, m)          the derivative of am by u, sqrt(1 - m*sn(u, m)^2)
kepler(M, e)      the eccentric anomaly E of the mean one: E - e*sin(E) = M, e from 0 to 1
if(CONDITION, a, b)  a where the condition holds, else b: if(x > 0 and not t > 2, a, b)
integral(EXPR)    in observe: what adds up from 0 on, with 'while CONDITION' while it holds
error(NAME)       by how much NAME is off its closed form, 'exact NAME = …'
power(NAME)       the power of a force or torque with a name
loss(NAME)        the energy that an impact, a contact, a friction or a mode has taken so far
dot(u, v)         the scalar product of two vectors
cross(u, v)       the vector product
norm(v)           the length of a vector
sum(EXPR, i = lo..hi)  the sum of EXPR over i; several ranges may follow
rot(AXIS, ANGLE)  the turning by an angle about an axis; turnings are composed by *
omega(R)          the rates of a rotation, in the frame of the body
inverse(R)        the turning back: from space to the body
euler(R)          [phi, theta, psi] with R = rot(z, phi)*rot(x, theta)*rot(z, psi)
tait_bryan(R)     [yaw, pitch, roll] with R = rot(z, yaw)*rot(y, pitch)*rot(x, roll)
drift(X)          in expect: how far X comes from its start in the whole run
time(EVENT)       in expect: when the event first happens
"""
_BUILT_IN = {"T": "the kinetic energy", "V": "the potential energy", "L": "the Lagrangian, T - V"}
_BUILT_IN["V_eff"] = "the effective potential: the energy with constant momenta and no other rates"


def calls() -> dict[str, tuple[str, str]]:
    """Maps the name of each function to the text of a call, such as "norm(v)", and a
    description."""
    rows = (line.partition(")") for line in _CALLS.strip().split("\n"))
    return {form.partition("(")[0]: (f"{form})", what.strip()) for form, _, what in rows}


def built_in() -> dict[str, str]:
    """Returns the names that every model has, with their descriptions."""
    origin = {ORIGIN: "the origin, unless the model has an O of its own", GROUND: "what stands"}
    return CONSTANTS | _BUILT_IN | origin


@cache
def words() -> dict[str, tuple[str, ...]]:
    """Returns the words of the language by class. `statement`: keywords that are reserved
    everywhere. `named`: words that are keywords only before a name or a string at the start of a
    line; `joining` stand between names in such statements. `opening`: words that are keywords only
    at the start of a statement. `part`: keywords behind a value in some statements; `parted` lists
    these, but for drawings. `clause`: keywords in any
    statement. `function`: words that are keywords before a bracket."""
    parts = {part for shape in SHAPES.values() for part in shape.parts}
    bodies = {word for words in CLAUSES.values() for word in words} | KINDS.keys()
    behind = {word for words in BEHIND.values() for word in words}
    found = {
        "statement": {word for word, row in STATEMENTS.items() if not row.soft},
        "opening": {w for w, row in STATEMENTS.items() if row.soft and not row.before_name},
        "named": {word for word, row in STATEMENTS.items() if row.before_name},
        "joining": {"as", "with"},
        "clause": CLAUSE_WORDS,
        "shape": SHAPES.keys(),
        "part": parts | FORMS.keys() | bodies | behind | {TO},
        "parted": CLAUSES.keys() | {word.lower() for word in BEHIND},
        "function": callable_names() | SPECIAL,
        "constant": CONSTANTS.keys(),
        "method": {TABLEAU},
        "member": frozenset(COMPONENTS) | frozenset(SHOWN),
        "plane": PLANES.keys(),
    }
    return {kind: tuple(sorted(of)) for kind, of in found.items()}
