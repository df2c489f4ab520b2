"""Turns Equations into a Program: straight-line C of every kernel as text, and operation counts.

Expressions of parameters alone are hoisted: `prepare` computes them once, into members of the
parameter struct. `rewrite.py` handles powers and products, `schedule.py` order, names and sharing,
`expressions.py` C text, and `chunk.py` very long kernels.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from ...equations import Equations
from ...graph.differentiate import symbols_in
from ...graph.graph import BIT, Graph, Kind, Node, Symbol
from ...middle.derive.switches import sides
from ...middle.structure import Structure
from ...record import record
from ..kernels import KERNELS, KernelSpec, kernel, needed_kernels
from ..targets import LOAD, STORE, Output, Target
from .chunk import blocks
from .constants import constants
from .expressions import Code, variable
from .hoist import Hoisting, rewritten
from .jet_kernel import Jet, jet
from .names import FIELD_RESERVED, LOCAL_RESERVED, Names, local_wish
from .program import LANES, Field, Interval, Kernel, Program, Statement, operations_in
from .rewrite import SIDE, rewrite
from .schedule import Schedule

__all__ = ["Program", "lower"]

# In embedded C an acceleration kernel with more operations solves M a = f by a loop.
LONG = 1000
_ARGUMENT = {
    Kind.COORDINATE: "q",
    Kind.RATE: "v",
    Kind.INPUT: "u",
    Kind.ACCELERATION: "a",
    Kind.MOMENTUM: "momenta",
}


def lower(
    equations: Equations,
    structure: Structure,
    kernels: frozenset[str] | None = None,
    *,
    libm: bool = False,
    kept: frozenset[int] | None = None,
    plain: bool = False,
    jets: bool = False,
) -> Program:
    """Returns straight-line code of the named kernels (None: of all that the model has). With
    `libm` sines and cosines are computed by the C library. Parameters whose index is not in `kept`
    are left out (None: none). With `plain` the C is to be embedded, without tables for the
    runtime. With `jets` the kernel `jet` belongs to all kernels."""
    made = _Lowering(equations, structure, libm, kept, plain).program(kernels, jets)
    solve = made.kernel("acceleration") if plain and not equations.constraints else None
    if solve is None or solve.operations.total() <= LONG or "mass" not in (kernels or {"mass"}):
        return made
    # For a pendulum of 20 links straight-line code is twice as fast as a loop, but takes half of
    # the file.
    by_loop = replace(equations, acceleration=None)
    return _Lowering(by_loop, structure, libm, kept, plain).program(kernels, jets)


def parameters_read(equations: Equations, kernels: frozenset[str] | None) -> frozenset[int]:
    """Returns the indices of the parameters in the named kernels and the initial values."""
    specs = (kernel(name) for name in (*needed_kernels(equations, kernels), "start"))
    nodes = [x for spec in specs for t in spec.targets(equations) for x in t.nodes]
    return _parameters_in(equations.graph, nodes)


def with_dependents(equations: Equations, read: frozenset[int]) -> frozenset[int]:
    """Returns the indices `read` of parameters, completed: by the other members of their families,
    and by all parameters on which the defaults of these depend."""
    slots, kept = equations.parameters, set(read)
    families = {slots[k].family for k in kept}
    for k in reversed(range(len(slots))):  # A default depends on earlier parameters only.
        if k in kept or slots[k].family in families:
            kept.add(k)
            more = _parameters_in(equations.graph, [slots[k].default])
            kept |= more
            families |= {slots[i].family for i in more}
    return frozenset(kept)


def _parameters_in(g: Graph, nodes: Iterable[Node]) -> frozenset[int]:
    return frozenset(s.index for s in symbols_in(g, nodes, BIT[Kind.PARAMETER]))


@record
class _Draft:
    """A kernel with rewritten expressions but no statements yet; they need the hoisted constants'
    names."""

    spec: KernelSpec
    targets: list[Target]
    hints: dict[Node, str]
    kept: frozenset[Node]


class _Lowering(Hoisting):
    def __init__(
        self,
        equations: Equations,
        structure: Structure,
        libm: bool,
        kept: frozenset[int] | None,
        plain: bool,
    ) -> None:
        self.plain = plain
        slots = equations.parameters
        numbers = range(len(slots)) if kept is None else sorted(kept)
        self.equations = equations = replace(equations, parameters=tuple(slots[k] for k in numbers))
        super().__init__(equations.graph, equations.model.name, libm)
        self.structure = structure
        c = equations.constraints
        positions = () if c is None else c.positions
        decided = {} if plain else sides(equations.graph, equations.switches, positions)
        for call, (switch, sign) in decided.items():
            self.work.side(call, Symbol(SIDE, switch), sign)
        self.fields, self.parameter_names, self.tables = _fields(equations)
        self.parameters = dict(zip(numbers, self.parameter_names, strict=True))
        self.symbols = _local_names(equations)

    def program(self, wanted: frozenset[str] | None, jets: bool = False) -> Program:
        names = needed_kernels(self.equations, wanted, self.plain, jets)
        specs = [kernel(name) for name in (*KERNELS, *sorted(names - {*KERNELS})) if name in names]
        drafts = [self._draft(spec) for spec in specs]
        roots = [x for d in drafts for t in d.targets for x in t.nodes]
        self.drafts = drafts
        hoisting = self.hoist(roots, self._names())
        prepare = self._finished("prepare", "int", (), hoisting, {})
        parameters, tables = self.equations.parameters, self.equations.model.tables
        # The members of lanes are numbers, not pointers. With contacts each has its own modes.
        in_lanes = not self.plain and not tables and not self.equations.model.meets
        lanes = tuple(f for f in LANES if in_lanes and (wanted is None or f in wanted))
        jets = [
            self._jet(draft, "members" in lanes) for draft in drafts if draft.spec.name == "jet"
        ]
        return Program(
            equations=self.equations,
            structure=self.structure,
            fields=self.fields,
            parameter_names=self.parameter_names,
            defaults=tuple(
                tuple(self._fixed_code([Target(STORE, f"p->{name}", (x.default,))]).statements)
                for name, x in zip(self.parameter_names, parameters, strict=True)
            ),
            bounds=tuple(self._interval(x.lo, x.hi) for x in parameters),
            prepare=prepare,
            constants=tuple(self.constants),
            start=self._start(),
            kernels=tuple(self._kernel(draft) for draft in drafts if draft.spec.name != "jet"),
            jet=jets[0] if jets else None,
            float_too=self.work.constants.float_too,
            helpers=tuple(sorted(self.helpers)),
            lanes=lanes,
            tables=tuple(zip(self.tables.values(), tables, strict=True)),
            plain=self.plain,
        )

    def named(self, nodes: list[Node], found: Mapping[Node, Node]) -> list[str]:
        known = {node: name for draft in self.drafts for node, name in draft.hints.items()}
        hints = {node: known.get(found[node], "") for node in nodes}
        fields = (*(x.c_name for x in self.fields), *self.tables.values())
        free = Names(FIELD_RESERVED, fields, self.prefix)
        self.constants = constants(self.work, nodes, self.fixed_leaf, free, hints)
        return [x.c_name for x in self.constants]

    def _names(self, taken: Iterable[str] = ()) -> Names:
        return Names(LOCAL_RESERVED, taken, self.prefix)

    def _draft(self, spec: KernelSpec) -> _Draft:
        targets = spec.targets(self.equations)
        roots = [node for target in targets for node in target.nodes]
        asked = set(spec.kept(self.equations))
        below = set(self.work.reachable(roots)) if asked else set()
        kept = sorted(asked & below)
        new = rewrite(self.work, roots + kept)
        hints = {node: name for node, name in spec.hints(self.equations) if node in new}
        return _Draft(
            spec,
            rewritten(targets, new),
            {new[x]: hints[x] for x in hints},
            frozenset(new[x] for x in kept),
        )

    def _jet(self, draft: _Draft, in_lanes: bool) -> Jet:
        names = [*self.parameter_names, *(x.c_name for x in self.constants)]
        places = {name: k for k, name in enumerate(names)} if in_lanes else None
        roots = [target.nodes[0] for target in draft.targets]
        return jet(self.equations, self.work, roots, self.leaf, places)

    def _kernel(self, draft: _Draft) -> Kernel:
        spec, n = draft.spec, len(self.equations.coordinates)
        outputs = spec.outputs(self.equations)
        names = self._names(o.name for o in outputs)
        for name in self.symbols.values():
            names.take(name)
        schedule = self.scheduled(draft.targets, names, hints=draft.hints, kept=draft.kept)
        loads = {
            name: Statement.of(LOAD, name, variable(f"{_ARGUMENT[symbol.kind]}[{symbol.index}]"))
            for symbol, name in self.symbols.items()
        }
        solves = spec.name == "acceleration" and self.equations.acceleration is None and n > 0
        return self._finished(spec.name, spec.result, outputs, schedule, loads, solves)

    def _finished(
        self,
        name: str,
        result: str,
        outputs: tuple[Output, ...],
        schedule: Schedule,
        loads: dict[str, Statement],
        solves: bool = False,
    ) -> Kernel:
        parts, work = blocks(schedule.statements, loads, [o.name for o in outputs])
        operations = operations_in(schedule.statements)
        return Kernel(name, result, outputs, parts, work, operations, solves)

    def symbol(self, symbol: Symbol) -> Code:
        if symbol.kind is Kind.PARAMETER:
            return variable("p->" + self.parameters[symbol.index])
        if symbol.kind is SIDE:
            return variable(f"p->side_[{symbol.index}]")
        return variable(self.symbols[symbol])

    # Functions that depend on parameters alone

    def _start(self) -> Kernel:
        spec, e = KERNELS["start"], self.equations
        code = self._fixed_code(spec.targets(e))
        return self._finished("start", spec.result, spec.outputs(e), code, {})

    def _fixed_code(self, targets: list[Target]) -> Schedule:
        """Returns the code of targets that depend on parameters alone. It reads no hoisted
        constants, since it may run before `prepare`."""
        new = rewrite(self.work, [x for t in targets for x in t.nodes], gather=False)
        return self.scheduled(rewritten(targets, new), self._names(), fixed=True)

    def _interval(self, lo: Node | None, hi: Node | None) -> Interval:
        ends = [("lo", lo), ("hi", hi)]
        targets = [Target(STORE, where, (node,)) for where, node in ends if node is not None]
        statements = self._fixed_code(targets).statements if targets else []
        values = {s.target: s.text for s in statements if s.kind == STORE}
        before = tuple(s for s in statements if s.kind != STORE)
        return Interval(before, values.get("lo"), values.get("hi"))


def _fields(equations: Equations) -> tuple[tuple[Field, ...], tuple[str, ...], dict[str, str]]:
    """Returns the members of struct NAME_params, C text for each scalar parameter, and the member
    of each table."""
    names = Names(FIELD_RESERVED, (), equations.model.name + "_")
    fields: list[Field] = []
    scalars: list[str] = []
    for index, slot in enumerate(equations.parameters):
        if slot.position == 0:
            fields.append(Field(names.take(slot.family), slot.length, index))
        place = f"[{slot.position}]" if slot.length else ""
        scalars.append(fields[-1].c_name + place)
    tables = {table.name: names.take(table.name) for table in equations.model.tables}
    return tuple(fields), tuple(scalars), tables


def _local_names(equations: Equations) -> dict[Symbol, str]:
    """Returns local names of coordinates, rates, inputs, accelerations and momenta."""
    names = Names(LOCAL_RESERVED, (), equations.model.name + "_")
    own = equations.own
    accelerations = [replace(c, name=c.name + "''") for c in equations.coordinates[:own]]
    accelerations += [replace(x, name=x.name + "'") for x in equations.rates[own:]]
    # The kernel `adjoint` has multipliers behind the accelerations.
    accelerations += [replace(x, name=f"mu_{x.name}") for x in equations.coordinates]
    rows = [
        (Kind.COORDINATE, equations.coordinates[:own]),  # no integrals of states
        (Kind.RATE, equations.rates),
        (Kind.INPUT, equations.inputs),
        (Kind.ACCELERATION, accelerations),
        (Kind.MOMENTUM, equations.momenta_names),
    ]
    return {
        Symbol(kind, index): names.take(local_wish(quantity.name))
        for kind, quantities in rows
        for index, quantity in enumerate(quantities)
    }
