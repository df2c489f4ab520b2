"""Checks calls of functions, sums and vectors."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import reduce

from ...functions import FUNCTIONS, VECTOR_FUNCTIONS, WRITTEN_OUT
from ...indices import indexed, integer
from ...model import Exact
from ...source import Span
from ...system.near import meant
from ...tree import Add, Call, Condition, Expr, Name, Range, Sum, Vector, names, of_member, within
from .. import units
from ..units import NONE, Dimension
from . import values as values_of
from .checking import Checked
from .conditions import truth
from .names import (
    EVENTS,
    ROTATIONS,
    SPECIAL,
    UNKNOWN,
    Facts,
    Members,
    Wrong,
    callable_names,
    joined,
)
from .rotations import RotationCalls
from .scope import PLACES, Scope
from .written import written


class Calls(RotationCalls):
    def __init__(self, *given, **more) -> None:
        super().__init__(*given, **more)
        self.tables: dict[str, tuple[str, bool, tuple[Dimension, ...]]] = {}
        self.powers: dict[str, tuple[Expr, Range | None]] = {}  # by name of a force
        # The energy lost in a contact, friction or latch by its name, and those that are asked for.
        self.losses: dict[str, Checked] = {}
        self.lost: set[str] = set()
        self.begins: dict[str, bool] = {}  # whether a mode is on at the start
        self.exacts: list[Exact] = []  # closed forms that are valid at the place being checked

    def call(self, expr: Call, scope: Scope) -> Checked:
        function = expr.function
        if function in ("drift", "time") and scope.place is PLACES["expect"]:
            return self._of_run(expr)
        if function == "power" and len(expr.arguments) == 1:
            return self._power(expr, scope)
        if function == "loss" and len(expr.arguments) == 1:
            return self._loss(expr, scope)
        if function == "error" and len(expr.arguments) == 1:
            return self._error(expr, scope)
        if function in ROTATIONS:  # The arguments may be rotations.
            return self.rotation_call(expr, [self.factor(x, scope) for x in expr.arguments])
        if function == "if":
            return self._if(expr, scope)
        arity, text = WRITTEN_OUT.get(function, (0, ""))
        given, at = expr.arguments, expr.span
        if function in ("min", "max") and len(given) > 2:
            return self.check(reduce(lambda a, b: Call(function, (a, b), at), given), scope)
        if text and len(given) == arity:
            self._pure(expr, scope)
            return self.check(written(text, at, *given), scope)
        parts = [self.check(argument, scope) for argument in expr.arguments]
        facts = [f for _, f in parts]
        if function in self.tables:
            return self._of_table(expr, parts, scope)
        if function not in callable_names():
            raise self._not_callable(expr)
        arity = arity or VECTOR_FUNCTIONS.get(function) or FUNCTIONS[function].arity
        if len(parts) != arity:
            count = "one argument" if arity == 1 else f"{arity} arguments"
            raise Wrong(f"{function} takes {count}, not {len(parts)}")
        vectors = function in VECTOR_FUNCTIONS
        for argument, part in zip(expr.arguments, facts, strict=True):
            if part.vector is (not vectors):
                raise self._other_rank(function, argument, vectors)
        found = self._vector_call if vectors else self._scalar_call
        return Call(function, tuple(e for e, _ in parts), expr.span), found(expr, facts)

    def _pure(self, expr: Call, scope: Scope) -> None:
        """Checks the argument of ceil and round, whose rewritten forms give other messages."""
        if expr.function not in ("ceil", "round"):
            return
        (argument,) = expr.arguments
        before = self.report.count
        _, facts = self.check(argument, scope)
        if self.report.count == before and facts.dimension not in (None, NONE):
            self.not_pure(expr.function, argument, facts)
        if self.report.count > before:
            raise Wrong

    def _of_run(self, expr: Call) -> Checked:
        """Checks drift(X) and time(EVENT), functions of a whole run that only `expect` may call."""
        if len(expr.arguments) != 1:
            raise Wrong(f"{expr.function} takes one argument")
        (argument,) = expr.arguments
        if expr.function == "time":
            return expr, self._time_of(argument)
        new, facts = self.check(argument, Scope(PLACES["record"]))
        at = argument.span
        if facts.vector:
            raise Wrong("the drift of a vector: take a component (.x, .y, .z)", at=at)
        if facts.known and not facts.moves:
            text = self.text(argument)
            raise Wrong(f"{text} does not move: it has no drift", at=at)
        return replace(expr, arguments=(new,)), Facts(NONE) if facts.known else UNKNOWN

    def _time_of(self, argument: Expr) -> Facts:
        name = argument.id if isinstance(argument, Name) else ""
        entry = self.names.table.get(name)
        if entry is not None and entry.kind in EVENTS:
            return Facts(self.time_dimension)
        if entry is not None and entry.kind == "poisoned":
            raise Wrong
        events = [n for n, e in self.names.table.items() if e.kind in EVENTS]
        help = f"the events are: {', '.join(events)}" if events else "declare it by 'event'"
        help = meant(name, events) or help
        raise Wrong("time(…) takes an event: when it first happens", help, argument)

    def _power(self, expr: Call, scope: Scope) -> Checked:
        """Checks power(NAME), the power of a named force, which becomes dot(force, velocity)."""
        (argument,) = expr.arguments
        name = argument.id if isinstance(argument, Name) else ""
        entry = self.names.table.get(name)
        if entry is not None and entry.kind == "poisoned":
            raise Wrong
        if entry is None or entry.kind != "force":
            if name in self.names.later and entry is None:
                self.names.unknown(name, argument.span)
                raise Wrong
            help = meant(name, self.powers) or "name one: force drag at P = [Fx, Fy, Fz]"
            raise Wrong("power(…) takes the name of a force or a torque", help, argument)
        if "coordinate" not in scope.place.kinds:
            raise Wrong(f"{scope.place.what} cannot use a power")
        if not self.indices.member(argument, entry, scope):
            raise Wrong
        value, range_ = self.powers[name]
        if range_ is not None:
            value = of_member(value, range_.variable, argument.index)
        return value, entry.facts

    def _loss(self, expr: Call, scope: Scope) -> Checked:
        """Checks loss(NAME), the energy that a contact, a friction or a latch has taken so far."""
        (argument,) = expr.arguments
        name = argument.id if isinstance(argument, Name) else ""
        if isinstance(argument, Name) and argument.index is not None:
            index = self.indices.value(argument.index, Scope(PLACES["size"]))
            name = indexed(name, index) if index is not None else name
        if name not in self.losses:
            help = meant(name, self.losses) or "of one that stands above: contact floor: y >= 0"
            raise Wrong("loss(…) takes the name of a contact, a friction or a mode", help, argument)
        if not scope.place.accelerations:
            raise Wrong(f"{scope.place.what} cannot use a loss")
        self.lost.add(name)
        return self.losses[name]

    def _of_table(self, expr: Call, parts: list[Checked], scope: Scope) -> Checked:
        """Checks the value of a table. It is not known before a run, since a run may bring data."""
        key, bends, wanted = self.tables[expr.function]
        entry = self.names.table[expr.function]
        entry.used = True
        if "parameter" not in scope.place.kinds or scope.place is PLACES["param"]:
            raise Wrong(f"{scope.place.what} cannot use a table")
        if len(parts) != len(wanted):
            count = "one argument" if len(wanted) == 1 else f"{len(wanted)} arguments"
            raise Wrong(f"the table {expr.function} takes {count}, not {len(parts)}")
        for argument, (_, part), dimension in zip(expr.arguments, parts, wanted, strict=True):
            if part.vector:
                raise Wrong(f"{expr.function} needs a number", at=argument)
            if part.dimension not in (None, dimension):
                need, has = units.si_text(dimension) or "1", units.si_text(part.dimension) or "1"
                raise Wrong(f"{expr.function} takes [{need}], this is [{has}]", at=argument)
        result = joined(entry.facts.dimension, False, [f for _, f in parts])
        result.united, result.bare = True, False
        if result.moves and bends:
            result.rough = result.rough or expr.function
        name = f"{key}:{'0' * len(wanted)}"
        return Call(name, tuple(e for e, _ in parts), expr.span), result

    def _error(self, expr: Call, scope: Scope) -> Checked:
        """Checks error(x), by how much x is off its closed form, which becomes x - EXPR."""
        (argument,) = expr.arguments
        new, facts = self.check(argument, scope)
        name = argument.id if isinstance(argument, Name) else ""
        form = next((x for x in self.exacts if x.name == name), None)
        if form is None:
            help = f"closed forms are given of: {', '.join(x.name for x in self.exacts)}"
            help = help if self.exacts else "say it: exact x = EXPR; those of parts are left out"
            raise Wrong(f"{self.text(argument)} has no closed form here", help, argument)
        value = form.value
        if form.range is not None:
            ends = tuple(integer(end, self.sizes) for end in (form.range.lo, form.range.hi))
            entry = replace(self.names.table[name], members=Members(ends), kind="member")
            if not self.indices.member(argument, entry, scope):
                raise Wrong
            value = of_member(value, form.range.variable, argument.index)
        return Add((new, value), (1, -1), expr.span), joined(facts.dimension, False, [facts])

    def _if(self, expr: Call, scope: Scope) -> Checked:
        if len(expr.arguments) != 3:
            raise Wrong("if takes a condition and two values", "e.g. if(x > 0, k*x, 0)")
        condition, *values = expr.arguments
        self._whole(condition, scope)
        parts = [self.check(x, scope) for x in (truth(condition, self.cells), *values)]
        facts = [f for _, f in parts]
        for value, part in zip(values, facts[1:], strict=True):
            if part.vector:
                raise Wrong("if chooses between numbers; this is a vector", at=value)
        result = joined(self.common(tuple(values), facts[1:], "if"), False, facts)
        if facts[0].moves:
            result.rough = "if"
        result.value = self.constant(expr, facts, lambda x: values_of.called("select", x))
        return Call("select", tuple(e for e, _ in parts), expr.span), result

    @property
    def cells(self) -> set[str]:
        """The names of memory cells."""
        return {n for n, e in self.names.table.items() if e.kind == "memory cell"}

    def _whole(self, condition: Expr, scope: Scope) -> None:
        """Checks that == stands between indices, sizes, constants and memory cells."""
        for part in within(condition):
            if isinstance(part, Condition) and part.operator == "==":
                kinds = {name: e.kind for name, e in self.names.table.items()}
                ahead = self.names.later.keys() - kinds.keys()  # this is reported elsewhere
                used = {kinds.get(n, "") for n in names(part) - scope.variables - ahead}
                cells = {"constant"} if "memory cell" in used else set()
                if used - {"size", "memory cell"} - cells:
                    help = "a quantity equals a value for an instant only: use < or >"
                    raise Wrong("'==' compares indices, sizes and memory cells", help, part)

    def condition(self, expr: Condition, scope: Scope) -> Checked:
        help = "a condition stands in if(CONDITION, a, b), in an event, or behind 'while'"
        raise Wrong(f"{self.text(expr)} is a condition, not a number", help)

    def _not_callable(self, expr: Call) -> Wrong:
        if expr.function in SPECIAL - {"sum"}:
            return Wrong(f"{expr.function}(…) has no meaning here")
        entry = self.names.table.get(expr.function)
        if entry is None or entry.kind != "poisoned":
            start = expr.span.start
            word = self.source.text[start : expr.span.end].partition("(")[0].rstrip()
            self.names.unknown(expr.function, Span(start, start + len(word)), called=True)
        return Wrong()

    def _other_rank(self, function: str, argument: Expr, vectors: bool) -> Wrong:
        needs, is_ = ("a vector", "a number") if vectors else ("a number", "a vector")
        help = {
            "norm": "the magnitude of a number is abs(x)",
            "abs": "the magnitude of a vector is norm(v)",
        }.get(function, "")
        text = self.text(argument)
        return Wrong(f"{function} needs {needs}, {text} is {is_}", help, argument)

    def _vector_call(self, expr: Call, facts: list[Facts]) -> Facts:
        dims = [f.dimension for f in facts]
        result = joined(None, expr.function == "cross", facts)
        if expr.function == "norm":
            result.dimension = dims[0]
        elif None not in dims:
            result.dimension = units.times(*dims)
        return result

    def _scalar_call(self, expr: Call, facts: list[Facts]) -> Facts:
        function = FUNCTIONS[expr.function]
        for name, argument, part in zip(function.arguments, expr.arguments, facts, strict=True):
            if name == function.still and part.moves:
                message = f"the {name} of {expr.function} moves: its derivative is not known"
                raise Wrong(message, "write it with numbers and parameters alone", argument)
        dimension: Dimension | None = NONE
        if function.units == "none":
            for argument, part in zip(expr.arguments, facts, strict=True):
                if part.dimension not in (None, NONE):
                    self.not_pure(expr.function, argument, part)
        else:
            shared = self.common(expr.arguments, facts, expr.function)
            if function.units == "same":
                dimension = shared
            elif function.units == "root" and shared is not None:
                dimension = units.power(shared, Fraction(1, 2))
        result = joined(dimension, False, facts)
        if not function.smooth and result.moves and not result.rough:
            result.rough = expr.function
        result.value = self.constant(expr, facts, lambda x: values_of.called(expr.function, x))
        return result

    def sum(self, expr: Sum, scope: Scope) -> Checked:
        inner = self.indices.enter(expr.ranges, self.indices.around(expr, scope))
        if inner is None:
            raise Wrong
        body, facts = self.check(expr.body, inner)
        return Sum(body, expr.ranges, expr.span), replace(facts, value=None)

    def vector(self, expr: Vector, scope: Scope) -> Checked:
        parts = [self.check(item, scope) for item in expr.items]
        facts = [f for _, f in parts]
        if len(parts) != 3:
            message = f"a vector has three components, this has {len(parts)}"
            raise Wrong(message, "in a plane write [x, y, 0]")
        for item, part in zip(expr.items, facts, strict=True):
            if part.vector:
                raise Wrong("a component of a vector is a number", at=item)
        dimension = self.common(expr.items, facts, "a vector")
        return Vector(tuple(e for e, _ in parts), expr.span), joined(dimension, True, facts)
