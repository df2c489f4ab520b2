"""Functions of rotations: rot, inverse, omega, euler and tait_bryan; and what a declared rotation R
is made of.

R is an attitude in SO(3), body to space, by the unit quaternion R.w, R.x, R.y, R.z. Its rates are
those of the body frame, omega(R). Behind the check there are names of numbers alone: the
quaternion's numbers are states of the model, and the body rates are rates of three coordinates,
turn(R).x, .y and .z, which nothing depends on and nobody sees (quasi-coordinates: Whittaker,
Analytical Dynamics, section 30)."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from ...source import Span
from ...tree import AXES, Add, Call, Component, Expr, Multiply, Name, Negate, Number, Vector
from .. import units
from ..units import NONE
from .checking import Checked, Checking
from .names import UNKNOWN, Facts, Turn, Turns, joined
from .vectors import EXAMPLE, applied, component

_UNIT = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def quaternion_names(rotation: str) -> tuple[str, ...]:
    """In the order in which they are states."""
    return tuple(f"{rotation}.{axis}" for axis in "wxyz")


def rate_names(rotation: str) -> tuple[str, ...]:
    """Of the body rates, as they are written: omega(R).x, .y, .z."""
    return tuple(f"omega({rotation}).{axis}" for axis in AXES)


def turn_names(rotation: str) -> tuple[str, ...]:
    """Of the coordinates whose rates these are, which nobody can write."""
    return tuple(f"turn({rotation}).{axis}" for axis in AXES)


def attitude(name: str, span: Span) -> Turn:
    """A declared rotation as it stands."""
    numbers = tuple(Name(number, None, span) for number in quaternion_names(name))
    return Turn(quaternion=Vector(numbers, span), name=name)


def quaternion_of(turns: Turns, span: Span) -> tuple[Expr, ...]:
    """The unit quaternion w, x, y, z of a product of rot(AXIS, ANGLE)s, without declared rotations
    among them: Euler's cos(angle/2), sin(angle/2) axis/|axis| each. () of none."""

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
    """Of two quaternions: i j = k, j k = i, k i = j."""

    def row(*terms: tuple[int, int, int]) -> Expr:
        return Add(tuple(times(a[i], b[j]) for _, i, j in terms), tuple(s for s, *_ in terms), span)

    return (
        row((1, 0, 0), (-1, 1, 1), (-1, 2, 2), (-1, 3, 3)),
        row((1, 0, 1), (1, 1, 0), (1, 2, 3), (-1, 3, 2)),
        row((1, 0, 2), (1, 2, 0), (1, 3, 1), (-1, 1, 3)),
        row((1, 0, 3), (1, 3, 0), (1, 1, 2), (-1, 2, 1)),
    )


class RotationCalls:
    """`x` checks the arguments."""

    def __init__(self, x: Checking) -> None:
        self.x, self.report, self.mismatch = x, x.report, x.mismatch
        self._of = {
            "rot": self._rot,
            "inverse": self._inverse,
            "omega": self._omega,
            "euler": self._euler,
            "tait_bryan": self._tait_bryan,
        }

    def call(self, expr: Call, parts: list[Checked]) -> Checked:
        """The call with its arguments, which are checked already. What is wrong is reported, and
        UNKNOWN; of a rotation the `turns` of the facts are what counts, not the expression."""
        if expr.function != "rot":
            if len(parts) != 1:
                message = f"{expr.function} takes one rotation, not {len(parts)} arguments"
                self.report.error(message, expr.span, f"e.g. {expr.function}(R)")
                return expr, UNKNOWN
            ((argument, facts),) = parts
            if not facts.turns:
                if facts.known:
                    self.report.error(
                        f"{expr.function} takes a rotation, {self.mismatch.text(argument)} is none",
                        expr.arguments[0].span,
                        "declare one: rotation R; or make one of an axis and an angle: rot(n, a)",
                    )
                return expr, UNKNOWN
        return self._of[expr.function](expr, parts)

    def _rot(self, expr: Call, parts: list[Checked]) -> Checked:
        if len(parts) != 2:
            self.report.error(
                f"rot takes an axis and an angle, not {len(parts)} arguments",
                expr.span,
                f"e.g. {EXAMPLE}",
            )
            return expr, UNKNOWN
        (axis, of_axis), (angle, of_angle) = parts
        if of_axis.turns or of_axis.vector is False:
            what = "rotation" if of_axis.turns else "number"
            self.report.error(
                f"the axis of a rotation is a vector, {self.mismatch.text(axis)} is a {what}",
                expr.arguments[0].span,
                f"e.g. {EXAMPLE}",
            )
        elif of_angle.turns or of_angle.vector:
            what = "rotation" if of_angle.turns else "vector"
            self.report.error(
                f"the angle of a rotation is a number, {self.mismatch.text(angle)} is a {what}",
                expr.arguments[1].span,
            )
        else:
            if of_angle.dimension not in (None, NONE):
                self.mismatch.argument("rot", expr.arguments[1], of_angle)
            if not (of_axis.known and of_angle.known):
                return expr, UNKNOWN
            turn = Turn(axis, angle)
            return expr, replace(joined(NONE, True, [of_axis, of_angle]), turns=(turn,))
        return expr, UNKNOWN

    def _inverse(self, expr: Call, parts: list[Checked]) -> Checked:
        facts = parts[0][1]
        return expr, replace(facts, turns=tuple(map(_backwards, reversed(facts.turns))))

    def _omega(self, expr: Call, parts: list[Checked]) -> Checked:
        """The rates of the body frame, of a declared rotation alone."""
        facts = parts[0][1]
        name = facts.turns[0].name if len(facts.turns) == 1 else ""
        if not name:
            self.report.error(
                "omega takes the name of a rotation",
                expr.arguments[0].span,
                _of_no_name(facts.turns),
            )
            return expr, UNKNOWN
        names = (Name(rate, None, expr.span) for rate in rate_names(name))
        rates = Facts(
            units.over(NONE, self.x.time_dimension),
            True,
            united=True,
            coordinates=facts.coordinates,
            rates=facts.coordinates,
        )
        return Vector(tuple(names), expr.span), rates

    def _euler(self, expr: Call, parts: list[Checked]) -> Checked:
        """[phi, theta, psi] of rot(z, phi)*rot(x, theta)*rot(z, psi); theta from 0 to pi."""
        z, bottom = self._column(expr, parts, "z"), self._row(expr, parts, "z")
        phi = _atan2(z[0], Negate(z[1], expr.span))
        theta = _atan2(_length(z[0], z[1]), z[2])
        psi = _atan2(bottom[0], bottom[1])
        return self._angles(expr, parts, phi, theta, psi)

    def _tait_bryan(self, expr: Call, parts: list[Checked]) -> Checked:
        """[yaw, pitch, roll] of rot(z, yaw)*rot(y, pitch)*rot(x, roll), pitch within a right
        angle."""
        x, bottom = self._column(expr, parts, "x"), self._row(expr, parts, "z")
        yaw = _atan2(x[1], x[0])
        pitch = _atan2(Negate(x[2], expr.span), _length(x[0], x[1]))
        roll = _atan2(bottom[1], bottom[2])
        return self._angles(expr, parts, yaw, pitch, roll)

    def _angles(self, expr: Call, parts: list[Checked], *angles: Expr) -> Checked:
        facts = parts[0][1]
        return Vector(angles, expr.span), replace(joined(NONE, True, [facts]), united=True)

    def _column(self, expr: Call, parts: list[Checked], axis: str) -> list[Expr]:
        """Of the matrix of the rotation: where it takes a unit vector of the body."""
        return self._parts(parts[0][1].turns, axis, expr.span)

    def _row(self, expr: Call, parts: list[Checked], axis: str) -> list[Expr]:
        backwards = tuple(map(_backwards, reversed(parts[0][1].turns)))
        return self._parts(backwards, axis, expr.span)

    @staticmethod
    def _parts(turns: Turns, axis: str, span: Span) -> list[Expr]:
        unit = Vector(tuple(Number(Fraction(n), span) for n in _UNIT[axis]), span)
        whole = applied(turns, unit, span)
        return [Component(whole, k, span) for k in range(len(AXES))]


def _of_no_name(turns: Turns) -> str:
    """How body rates are had of what is no declared rotation."""
    if len(turns) > 1:
        return "of a product of rotations the rates are in several frames: add them as vectors"
    if turns[0].quaternion is not None:
        return "of inverse(R) they are -(R*omega(R))"
    return "of rot(n, a) they are a'*n, where n is constant and of length 1"


def _backwards(turn: Turn) -> Turn:
    if turn.quaternion is None:
        return replace(turn, angle=Negate(turn.angle, turn.angle.span))
    w, x, y, z = turn.quaternion.items
    opposite = tuple(p.of if isinstance(p, Negate) else Negate(p, p.span) for p in (x, y, z))
    return Turn(quaternion=Vector((w, *opposite), turn.quaternion.span))


def _atan2(y: Expr, x: Expr) -> Expr:
    return Call("atan2", (y, x), y.span)


def _length(a: Expr, b: Expr) -> Expr:
    return Call("norm", (Vector((a, b), a.span),), a.span)
