"""Schedules the statements of one kernel: their order, local variables, inline expressions.

A value used twice (a common subexpression), or too long for a line, becomes a local constant; any
other value is written where it is used. A local comes just before its first use, a sine together
with the cosine of the same angle (one call of the inline function gives both), an output as soon as
its value is known.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache

from ...functions import FUNCTIONS, SIDE, Function
from ...graph.graph import Node, Op
from ...graph.nodes import SQUARES
from ..targets import LOCAL, TRIG, Target
from .expressions import (
    ONE,
    PI,
    Code,
    Form,
    added,
    atom,
    called,
    code,
    constant,
    inverted,
    joined,
    literal,
    multiplied,
    negated,
    variable,
)
from .helpers import helper_name
from .names import Names
from .program import Statement
from .rewrite import Workspace

# The largest lengths, in characters, of an expression, of a part in brackets, and of the name of a
# local variable.
_LONGEST = 150
_LONGEST_PART = 64
_LONGEST_NAME = 32


@dataclass
class Schedule:
    """Builds the statements of one kernel. `leaf` returns the C text of symbols and hoisted values,
    None for nodes to be computed; `hints` are preferred names of local variables."""

    work: Workspace
    names: Names
    prefix: str
    leaf: Callable[[Node], Code | None]
    hints: Mapping[Node, str] = field(default_factory=dict)
    kept: frozenset[Node] = frozenset()  # nodes that must become local variables
    known_after: frozenset[str] = frozenset()  # outputs that later statements read
    tables: Mapping[str, str] = field(default_factory=dict)  # by name: member of NAME_params
    inline_sincos: bool = False  # whether sines are computed inline or by libm
    statements: list[Statement] = field(default_factory=list)
    helpers: set[str] = field(default_factory=set)
    _forms: dict[Node, Form] = field(default_factory=dict)
    _local: set[Node] = field(default_factory=set)
    _angles: dict[Node, None] = field(default_factory=dict)  # Angles still to compute.

    def __post_init__(self) -> None:
        self.leaf = cache(self.leaf)  # it is called several times for each node

    def run(self, targets: Iterable[Target]) -> None:
        targets = list(targets)
        self._local = self._locals(targets)
        trig = [x for x in sorted(self._local) if self._is_trig(x)]
        angles = [a for x in trig for a in self.work.args[x] if self.leaf(a) is not None]
        self._angles = dict.fromkeys(angles)
        for target in targets:
            for node in target.nodes:
                self._compute(node)
            values = []
            for node in target.nodes:
                if target.template != "{0}":
                    self._promote(node, 0)
                values.append(code(self._forms[node]))
            reads, operations = joined(values)
            text = target.template.format(*values)
            value = Code(text, reads, (*operations, *target.operations))
            self.statements.append(Statement.of(target.kind, target.where, value))
            for place in target.also:
                copied = value if value == "0" else variable(target.where)
                self.statements.append(Statement.of(target.kind, place, copied))
            if target.where in self.known_after and self.leaf(target.nodes[0]) is None:
                self._forms[target.nodes[0]] = atom(variable(target.where))

    def _locals(self, targets: list[Target]) -> set[Node]:
        """Returns the nodes that become local variables: those of `kept`, those used several times
        (x or -x), and sines and cosines."""
        work, leaf = self.work, self.leaf
        uses: dict[Node, int] = {}
        pending = [node for target in targets for node in target.nodes]
        while pending:
            node = pending.pop()
            while node not in uses and leaf(node) is None:
                core = work.negated(node)
                if core is None:
                    pending.extend(work.args[node])
                    break
                node = core
            uses[node] = uses.get(node, 0) + 1
        local = {node for node, count in uses.items() if count > 1}
        local |= self.kept & uses.keys()
        for node in uses:
            if work.op[node] is Op.CALL and (self._partner(node) in uses or self._is_trig(node)):
                local.add(node)
        if self.known_after:  # Later statements read the output.
            local -= {node for target in targets for node in target.nodes}
        return {node for node in local if self.leaf(node) is None}

    def _partner(self, node: Node) -> Node | None:
        """Returns the node of the cosine of a sine's angle, or of the sine of a cosine's, if
        any."""
        if self.work.op[node] is not Op.CALL:
            return None
        other = SQUARES.get(str(self.work.data[node]))
        return other and self.work.find(Op.CALL, self.work.args[node], other)

    def _is_trig(self, node: Node) -> bool:
        """Returns whether the runtime's inline function computes the node, a sine or cosine."""
        call = self.work.op[node] is Op.CALL and str(self.work.data[node]) in SQUARES
        return call and self.inline_sincos

    def _compute(self, root: Node) -> None:
        """Computes the forms of the root and all nodes below it; arguments come first."""
        work, forms = self.work, self._forms
        stack = [root]
        while stack:
            node = stack[-1]
            if node in forms:
                stack.pop()
                continue
            if (leaf := self.leaf(node)) is not None:
                forms[node] = atom(leaf)
                if work.op[node] is Op.NUMBER:
                    forms[node] = constant(leaf)
                    work.constants.see(node)
                continue
            missing = [a for a in work.args[node] if a not in forms]
            if missing:
                stack.extend(reversed(missing))
                continue
            stack.pop()
            if work.fixed[node]:
                work.constants.see(node)
            if work.op[node] is not Op.CALL:
                self._finish(node)
                continue
            if self._is_trig(node):
                self._take_sines(*self.work.args[node])
                continue
            pair = [node]
            partner = self._partner(node)
            if partner is not None and partner in self._local and partner not in self._forms:
                pair.append(partner)
                pair.sort(key=lambda x: self.work.data[x] != "sin")
            for x in pair:
                self._finish(x)

    def _take_sines(self, angle: Node) -> None:
        """Adds a call of the inline function for the sine and cosine of an angle. It also computes
        another known angle, if there is one, since two angles fit in one SIMD vector."""
        self._promote(angle, _LONGEST_PART)
        self._angles.pop(angle, None)
        angles = [angle]
        if self._angles:
            angles.append(next(iter(self._angles)))
            self._compute(angles[1])
            del self._angles[angles[1]]
        values, places = [], []
        for x in angles:
            angle_form = self._forms[x]
            values.append(code(angle_form))
            for function in SQUARES:
                node = self.work.find(Op.CALL, (x,), function)
                if node is None or node not in self._local:
                    places.append("NULL")
                    continue
                places.append(self._name(node, angle_form, function))
                self._forms[node] = atom(variable(places[-1]))
        self.statements.append(Statement(TRIG, tuple(places), tuple(values)))

    def _finish(self, node: Node) -> None:
        self._forms[node] = self._form(node)
        if node in self._local:
            self._promote(node, 0)

    def _form(self, node: Node) -> Form:
        op, args = self.work.op[node], self.work.args[node]
        if (core := self.work.negated(node)) is not None:
            return negated(self._forms[core])
        forms = self._forms
        if op is Op.ADD:
            a, b = args
            if forms[a].length + forms[b].length > _LONGEST:
                self._fit(args, _LONGEST)
            return added(forms[a], forms[b])
        if op is Op.MULTIPLY:
            a, b = args
            for x in args:
                if forms[x].terms:
                    self._promote(x, _LONGEST_PART)
            if forms[a].length + forms[b].length > _LONGEST:
                self._fit(args, _LONGEST)
            return multiplied(forms[a], forms[b])
        for a in args:
            self._promote(a, _LONGEST_PART)
        if op is Op.POWER:
            assert self.work.data[node] == Fraction(-1)  # rewrite() has replaced all other powers.
            return inverted(forms[args[0]])
        function = str(self.work.data[node])
        row = FUNCTIONS[function.removeprefix(SIDE)]
        if row.table:
            return self._looked_up(row, [forms[a] for a in args])
        if row.body or function.startswith(SIDE):
            self.helpers.add(function)
            name, counted = self.prefix + helper_name(function), function.removeprefix(SIDE)
        else:
            counted = row.c or function
            name = f"PK_F({counted})"
        return called(name, [_typed(forms[a]) for a in args], counted)

    def _looked_up(self, row: Function, arguments: list[Form]) -> Form:
        table = variable(f"p->{self.tables[row.table]}")
        if not row.orders:
            axis = Code(f"&{table}->axes[{row.axis}]", table.reads)
            return called("pk_axis_place", [atom(axis), *arguments], "search")
        name = "pk_lookup" if len(row.orders) == 1 else "pk_lookup2"
        orders = (atom(Code(str(order))) for order in row.orders)
        return called(name, [atom(table), *orders, *map(_typed, arguments)], "lookup")

    def _fit(self, args: tuple[Node, ...], longest: int) -> None:
        """Makes the longest arguments local variables until the text of all arguments fits on a
        line."""
        for a in sorted(args, key=lambda a: -self._forms[a].length):
            if sum(self._forms[b].length for b in args) > longest:
                self._promote(a, 0)

    def _promote(self, node: Node, longest: int) -> None:
        """Makes a local of a node whose text is longer than `longest`."""
        form = self._forms[node]
        if form.length <= longest or self.leaf(node) is not None:
            return
        # The local's sign is positive, and its uses get the minus: -a - b is stored as a + b.
        sign = form.sign if not form.is_sum else max(sign for sign, _ in form.terms)
        form = negated(form) if sign < 0 else form
        value = code(form)
        if _at_hand(value):
            return
        op, args = self.work.op[node], self.work.args[node]
        library = op is Op.CALL and len(args) == 1 and value.startswith("PK_F(")
        name = self._name(
            node, self._forms[args[0]] if library else form, value.operations[-1] if library else ""
        )
        self.statements.append(Statement.of(LOCAL, name, value))
        local = atom(variable(name))
        self._forms[node] = negated(local) if sign < 0 else local

    def _name(self, node: Node, form: Form, function: str = "") -> str:
        """Returns a local's name for a node; its value is `form`, or `function` of `form`."""
        wish = self.hints.get(node) or _described(form, function)
        if wish and len(wish) <= _LONGEST_NAME and self.names.is_free(wish):
            return self.names.take(wish)
        return self.names.number("t")


def _typed(form: Form) -> Form:
    """Returns the argument of a function; an integer is written as a real. <tgmath.h> would compute
    in double for an int, whatever pk_real is."""
    text = code(form)
    return constant(f"PK_C({text}.0)") if text.isdigit() else form


def _at_hand(value: Code) -> bool:
    """Returns whether the text needs no local: a number, a name or a struct member."""
    if value.operations:
        return False
    is_name = value in value.reads and ("[" not in value or value.startswith("p->"))
    return is_name or value.isalnum() or value == PI


def _is_named(part: Code) -> bool:
    """Returns whether the text is a local variable with a descriptive name, unlike t7."""
    numbered = part[0] == "t" and part[1:].isdigit()
    return part.reads == (part,) and part.isidentifier() and part[0].islower() and not numbered


def _described(form: Form, function: str) -> str | None:
    """Returns a name: sin_theta1, theta1_minus_theta2, theta1_dot_sq; None if there is none."""
    if function:
        argument = code(form)
        return f"{function}_{argument}" if argument.isidentifier() else None
    if len(form.terms) == 2:
        (sign, a), (other, b) = sorted(form.terms, key=lambda term: -term[0])
        if sign > 0 and _is_named(a) and _is_named(b):
            return f"{a}_{'plus' if other > 0 else 'minus'}_{b}"
    elif len(form.above) == 2 and not form.below and form.above[0] == form.above[1]:
        return f"{form.above[0]}_sq" if _is_named(form.above[0]) else None
    elif form.above == (ONE,) and len(form.below) == 1 and _is_named(form.below[0]):
        return f"inv_{form.below[0]}"
    return None


def number_text(value: object) -> Code:
    """Returns a number, with its sign, as C text."""
    assert isinstance(value, Fraction)
    return Code(("-" if value < 0 else "") + literal(abs(value)))
