"""Checks the functions of rotations, rot, inverse, omega, euler and tait_bryan, and defines the
scalars of a declared rotation R.

R is an attitude in SO(3), body to space, given by the unit quaternion R.w, R.x, R.y, R.z. Its rates
are the body rates omega(R). A checked model contains only scalars: the four quaternion components
are states, and the body rates are the rates of three hidden coordinates turn(R).x, .y and .z, on
which nothing depends (quasi-coordinates: Whittaker, Analytical Dynamics, section 30)."""

from __future__ import annotations

from dataclasses import replace

from ...source import Span
from ...tree import AXES, Call, Component, Expr, Name, Negate, Vector
from .. import units
from ..units import NONE
from .checking import Checked, Checking
from .names import Facts, Turn, Turns, Wrong, joined
from .vectors import EXAMPLE, UNIT, applied, component
from .written import written


def quaternion_names(rotation: str) -> tuple[str, ...]:
    """Returns the names of the four quaternion states: R.w, R.x, R.y, R.z."""
    return tuple(f"{rotation}.{axis}" for axis in "wxyz")


def rate_names(rotation: str) -> tuple[str, ...]:
    """Returns the names of the body rates: omega(R).x, .y, .z."""
    return tuple(f"omega({rotation}).{axis}" for axis in AXES)


def turn_names(rotation: str) -> tuple[str, ...]:
    """Returns the names of the hidden coordinates whose rates are the body rates."""
    return tuple(f"turn({rotation}).{axis}" for axis in AXES)


def attitude(name: str, index: Expr | None, span: Span) -> Turn:
    """Returns the Turn (a factor of a product) for a declared rotation or a member of a family."""
    numbers = tuple(Name(number, index, span) for number in quaternion_names(name))
    return Turn(quaternion=Vector(numbers, span), name=name, index=index)


def quaternion_of(turns: Turns, span: Span) -> tuple[Expr, ...]:
    """Returns the unit quaternion w, x, y, z of a product of rot(AXIS, ANGLE). The quaternion of a
    factor is cos(angle/2), sin(angle/2) axis/|axis|. Returns () for no factors."""
    whole: tuple[Expr, ...] = ()
    for turn in turns:
        parts = (component(turn.axis, k) for k in range(len(AXES)))
        of_axis = (written("(sin(a/2)/norm(b))*c", span, turn.angle, turn.axis, x) for x in parts)
        one = written("cos(a/2)", span, turn.angle), *of_axis
        whole = tuple(written(row, span, *whole, *one) for row in _PRODUCT) if whole else one
    return whole


# The product of the quaternions a, b, c, d and e, f, g, h, with i j = k, j k = i, k i = j.
_PRODUCT = (
    "a*e - b*f - c*g - d*h",
    "a*f + b*e + c*h - d*g",
    "a*g + c*e + d*f - b*h",
    "a*h + d*e + b*g - c*f",
)
# The angles of a rotation, from a, b, c, the column of its matrix along an axis, and d, e, f, the
# column along z of its inverse: phi, theta, psi of rot(z, phi)*rot(x, theta)*rot(z, psi), theta in
# [0, pi]; yaw, pitch, roll of rot(z, yaw)*rot(y, pitch)*rot(x, roll), |pitch| <= pi/2.
_ANGLES = {
    "euler": ("z", ("atan2(a, -b)", "atan2(norm([a, b]), c)", "atan2(d, e)")),
    "tait_bryan": ("x", ("atan2(b, a)", "atan2(-c, norm([a, b]))", "atan2(e, f)")),
}


class RotationCalls(Checking):
    def rotation_call(self, expr: Call, parts: list[Checked]) -> Checked:
        """Checks a call such as rot(...), whose arguments `parts` have been checked. If the result
        is a rotation, only `turns`, its list of factors, is valid in the returned facts, and the
        returned expression is not used."""
        if expr.function == "rot":
            return self._rot(expr, parts)
        if len(parts) != 1:
            message = f"{expr.function} takes one rotation, not {len(parts)} arguments"
            raise Wrong(message, f"e.g. {expr.function}(R)")
        ((argument, facts),) = parts
        if not facts.known:
            raise Wrong
        if not facts.turns:
            message = f"{expr.function} takes a rotation, {self.text(argument)} is none"
            help = "declare one: rotation R; or make one of an axis and an angle: rot(n, a)"
            raise Wrong(message, help, expr.arguments[0])
        if expr.function == "inverse":
            return expr, replace(facts, turns=_inverse(facts.turns))
        if expr.function == "omega":
            return self._omega(expr, facts)
        (axis, texts), at = _ANGLES[expr.function], expr.span
        columns = *_column(facts.turns, axis, at), *_column(_inverse(facts.turns), "z", at)
        found = Vector(tuple(written(text, at, *columns) for text in texts), at)
        return found, replace(joined(NONE, True, [facts]), united=True)

    def _rot(self, expr: Call, parts: list[Checked]) -> Checked:
        if len(parts) != 2:
            message = f"rot takes an axis and an angle, not {len(parts)} arguments"
            raise Wrong(message, f"e.g. {EXAMPLE}")
        (axis, of_axis), (angle, of_angle) = parts
        if of_axis.turns or of_axis.vector is False:
            what = "rotation" if of_axis.turns else "number"
            message = f"the axis of a rotation is a vector, {self.text(axis)} is a {what}"
            raise Wrong(message, f"e.g. {EXAMPLE}", expr.arguments[0])
        if of_angle.turns or of_angle.vector:
            what = "rotation" if of_angle.turns else "vector"
            text = self.text(angle)
            message = f"the angle of a rotation is a number, {text} is a {what}"
            raise Wrong(message, at=expr.arguments[1])
        if of_angle.dimension not in (None, NONE):
            self.not_pure("rot", expr.arguments[1], of_angle)
        if not (of_axis.known and of_angle.known):
            raise Wrong
        turn = Turn(axis, angle)
        return expr, replace(joined(NONE, True, [of_axis, of_angle]), turns=(turn,))

    def _omega(self, expr: Call, facts: Facts) -> Checked:
        """Checks omega(R), the body rates of a declared rotation."""
        turn, *more = facts.turns
        if more or not turn.name:
            help, at = _of_no_name(facts.turns), expr.arguments[0].span
            raise Wrong("omega takes the name of a rotation", help, at)
        names = tuple(Name(rate, turn.index, expr.span) for rate in rate_names(turn.name))
        per_time, own = units.over(NONE, self.time_dimension), facts.coordinates
        facts = Facts(per_time, True, united=True, coordinates=own, rates=own)
        return Vector(names, expr.span), facts


def _column(turns: Turns, axis: str, span: Span) -> list[Expr]:
    """Returns a column of a rotation's matrix: the rotated unit vector along `axis`."""
    whole = applied(turns, written(UNIT[axis], span), span)
    return [Component(whole, k, span) for k in range(len(AXES))]


def _inverse(turns: Turns) -> Turns:
    return tuple(map(_backwards, reversed(turns)))


def _of_no_name(turns: Turns) -> str:
    """Returns a hint on how to write the rates of a rotation without a name, such as inverse(R)."""
    if len(turns) > 1:
        return "of a product of rotations the rates are in several frames: add them as vectors"
    if turns[0].quaternion is not None:
        return "of inverse(R) they are -(R*omega(R))"
    if turns[0].columns or turns[0].rows:
        return "of a body they are its omega: link[i].omega"
    return "of rot(n, a) they are a'*n, where n is constant and of length 1"


def _backwards(turn: Turn) -> Turn:
    if turn.columns or turn.rows:
        return Turn(columns=turn.rows, rows=turn.columns)
    if turn.quaternion is None:
        return replace(turn, angle=Negate(turn.angle, turn.angle.span))
    w, x, y, z = turn.quaternion.items
    opposite = tuple(p.of if isinstance(p, Negate) else Negate(p, p.span) for p in (x, y, z))
    return Turn(quaternion=Vector((w, *opposite), turn.quaternion.span))
