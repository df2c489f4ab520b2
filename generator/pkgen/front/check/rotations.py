"""Checks the functions of rotations, rot, inverse, omega, euler and tait_bryan, and defines the
scalars of a declared rotation R.

R is an attitude in SO(3), body to space, given by the unit quaternion R.w, R.x, R.y, R.z. Its rates
are the body rates omega(R). A checked model contains only scalars: the four quaternion components
are states, and the body rates are the rates of three hidden coordinates turn(R).x, .y and .z, on
which nothing depends (quasi-coordinates: Whittaker, Analytical Dynamics, section 30)."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from ...source import Span
from ...tree import AXES, Add, Call, Component, Expr, Multiply, Name, Negate, Number, Vector
from .. import units
from ..units import NONE
from .checking import Checked, Checking
from .names import Facts, Turn, Turns, Wrong, joined
from .vectors import EXAMPLE, applied, component


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

    def times(a: Expr, b: Expr) -> Expr:
        return Multiply((a, b), (1, 1), span)

    whole: tuple[Expr, ...] = ()
    for turn in turns:
        half = Multiply((turn.angle, Number(Fraction(2), span)), (1, -1), span)
        along = Call("sin", (half,), span), Call("norm", (turn.axis,), span)
        unit = Multiply(along, (1, -1), span)
        one = (
            Call("cos", (half,), span),
            *(times(unit, component(turn.axis, k)) for k in range(len(AXES))),
        )
        whole = one if not whole else _product(whole, one, times, span)
    return whole


def _product(a: tuple[Expr, ...], b: tuple[Expr, ...], times, span: Span) -> tuple[Expr, ...]:
    """Returns the product of two quaternions, with i j = k, j k = i, k i = j."""

    def row(*terms: tuple[int, int, int]) -> Expr:
        return Add(tuple(times(a[i], b[j]) for _, i, j in terms), tuple(s for s, *_ in terms), span)

    return (
        row((1, 0, 0), (-1, 1, 1), (-1, 2, 2), (-1, 3, 3)),
        row((1, 0, 1), (1, 1, 0), (1, 2, 3), (-1, 3, 2)),
        row((1, 0, 2), (1, 2, 0), (1, 3, 1), (-1, 1, 3)),
        row((1, 0, 3), (1, 3, 0), (1, 1, 2), (-1, 2, 1)),
    )


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
            raise Wrong(
                f"{expr.function} takes a rotation, {self.text(argument)} is none",
                "declare one: rotation R; or make one of an axis and an angle: rot(n, a)",
                expr.arguments[0],
            )
        if expr.function == "inverse":
            return expr, replace(facts, turns=_inverse(facts.turns))
        if expr.function == "omega":
            return self._omega(expr, facts)
        angles = {"euler": _euler, "tait_bryan": _tait_bryan}[expr.function]
        found = Vector(angles(facts.turns, expr.span), expr.span)
        return found, replace(joined(NONE, True, [facts]), united=True)

    def _rot(self, expr: Call, parts: list[Checked]) -> Checked:
        if len(parts) != 2:
            message = f"rot takes an axis and an angle, not {len(parts)} arguments"
            raise Wrong(message, f"e.g. {EXAMPLE}")
        (axis, of_axis), (angle, of_angle) = parts
        if of_axis.turns or of_axis.vector is False:
            what = "rotation" if of_axis.turns else "number"
            raise Wrong(
                f"the axis of a rotation is a vector, {self.text(axis)} is a {what}",
                f"e.g. {EXAMPLE}",
                expr.arguments[0],
            )
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


def _euler(turns: Turns, span: Span) -> tuple[Expr, ...]:
    """Returns phi, theta, psi of rot(z, phi)*rot(x, theta)*rot(z, psi), theta in [0, pi]."""
    z, bottom = _column(turns, "z", span), _column(_inverse(turns), "z", span)
    phi = _atan2(z[0], Negate(z[1], span))
    theta = _atan2(_length(z[0], z[1]), z[2])
    psi = _atan2(bottom[0], bottom[1])
    return phi, theta, psi


def _tait_bryan(turns: Turns, span: Span) -> tuple[Expr, ...]:
    """Returns yaw, pitch, roll of rot(z, yaw)*rot(y, pitch)*rot(x, roll); |pitch| <= pi/2."""
    x, bottom = _column(turns, "x", span), _column(_inverse(turns), "z", span)
    yaw = _atan2(x[1], x[0])
    pitch = _atan2(Negate(x[2], span), _length(x[0], x[1]))
    roll = _atan2(bottom[1], bottom[2])
    return yaw, pitch, roll


def _column(turns: Turns, axis: str, span: Span) -> list[Expr]:
    """Returns a column of a rotation's matrix: the rotated unit vector along `axis`."""
    unit = Vector(tuple(Number(Fraction(int(axis == x)), span) for x in AXES), span)
    whole = applied(turns, unit, span)
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


def _atan2(y: Expr, x: Expr) -> Expr:
    return Call("atan2", (y, x), y.span)


def _length(a: Expr, b: Expr) -> Expr:
    return Call("norm", (Vector((a, b), a.span),), a.span)
