"""The result of `lower`: straight-line code as text, ready for the templates.

Expressions are text (`expressions.py` writes it); the templates and `tree.py` write everything
around them, from declarations to comments. Nothing here refers to the expression graph.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import field
from typing import Any, NamedTuple

from ...equations import Equations, Structure
from ...record import record
from ..targets import ADD, CHECK, FILL, LOAD, LOCAL, MIRROR, RETURN, STORE, TRIG, Output
from .constants import Constant
from .expressions import Code, base

LANES = ("lanes", "members")  # many states side by side, with one set of parameters or many

_SHOWN = {
    LOCAL: "{target} = {text}",
    TRIG: "{target} = sincos {text}",
    LOAD: "{target} = {text}",
    STORE: "{target} := {text}",
    ADD: "{target} += {text}",
    FILL: "{target}[0..{text} - 1] := 0",
    MIRROR: "{target}[j, i] := {target}[i, j], i < j < {text}",
    CHECK: "unless {text}: return {target}",
    RETURN: "return {text}",
}


class Statement(NamedTuple):
    kind: str
    targets: tuple[str, ...]
    values: tuple[Code, ...]

    @staticmethod
    def of(kind: str, target: str, value: Code) -> Statement:
        return Statement(kind, (target,), (value,))

    @property
    def target(self) -> str:
        return " ".join(self.targets)

    @property
    def text(self) -> str:
        return "; ".join(self.values)

    @property
    def reads(self) -> list[str]:
        return [read for value in self.values for read in value.reads]

    @property
    def names(self) -> set[str]:
        """Returns the variables that the statement reads or writes."""
        written = () if self.kind == CHECK else self.targets
        return {base(place) for place in (*self.reads, *written)}

    @property
    def defines(self) -> tuple[str, ...]:
        """Returns the local constants that the statement defines."""
        made = self.targets if self.kind in (LOCAL, LOAD, TRIG) else ()
        return tuple(name for name in made if name != "NULL")

    def __str__(self) -> str:
        return _SHOWN[self.kind].format(target=self.target, text=self.text)


@record
class Block:
    """A sequence of statements. Each block of a kernel but the last becomes a function, which
    passes values through a work array, since compilers are superlinear on straight-line code."""

    statements: tuple[Statement, ...]
    uses: frozenset[str]  # the arguments (p t q v u w ...) and outputs that it uses

    @property
    def checks(self) -> bool:
        return any(s.kind == CHECK for s in self.statements)


@record
class Kernel:
    name: str
    result: str  # the C type it returns
    outputs: tuple[Output, ...]
    blocks: tuple[Block, ...]
    work: int  # length of the array through which blocks pass values
    operations: Counter[str] = field(default_factory=Counter)
    solves: bool = False  # whether a loop solves M a = f; there are no statements then

    @property
    def uses(self) -> frozenset[str]:
        return frozenset().union(*(b.uses for b in self.blocks))

    @property
    def statements(self) -> Iterator[Statement]:
        return (s for block in self.blocks for s in block.statements)

    def __str__(self) -> str:
        lines = [f"kernel {self.name}: {operations_text(self.operations)}"]
        for number, block in enumerate(self.blocks):
            if number:
                lines.append(f"  -- block {number + 1}")
            lines.extend(f"  {s}" for s in block.statements)
        if self.solves:
            lines.append("  solve M a = f in a loop")
        return "\n".join(lines)


@record
class Assignment:
    """The default of one parameter, computed from earlier ones."""

    statements: tuple[Statement, ...]  # locals that the value needs
    text: str


@record
class Interval:
    """The bounds of one parameter; None is infinite."""

    statements: tuple[Statement, ...]  # locals that the bounds need
    lo: str | None
    hi: str | None

    @property
    def ends(self) -> tuple[str, str]:
        return self.lo or "-PK_INFINITY", self.hi or "PK_INFINITY"


@record
class Field:
    """A member of struct NAME_params: a parameter, or with `length` a family of them."""

    c_name: str
    name: str
    length: int  # 0 for a plain parameter
    first: int  # index of the (first) parameter


@record
class Program:
    equations: Equations
    structure: Structure
    fields: tuple[Field, ...]
    parameter_names: tuple[str, ...]  # the C text of each scalar parameter: "m1", "k[2]"
    defaults: tuple[Assignment, ...]
    bounds: tuple[Interval, ...]
    prepare: Kernel  # fills the hoisted constants
    constants: tuple[Constant, ...]  # the hoisted constants, with names
    start: Kernel
    kernels: tuple[Kernel, ...]
    float_too: bool  # whether the constants are in the range of float
    helpers: tuple[str, ...]  # functions that the C file must define: "min", "step", ...
    lanes: tuple[str, ...] = ()  # forms of the acceleration of many states, out of LANES
    plain: bool = False  # whether it is to be embedded, without tables for the runtime

    def kernel(self, name: str) -> Kernel | None:
        return next((k for k in self.kernels if k.name == name), None)

    @property
    def all_kernels(self) -> tuple[Kernel, ...]:
        return self.prepare, self.start, *self.kernels

    @property
    def has_sincos(self) -> bool:
        """Returns whether any kernel calls the inline pair of sine and cosine."""
        return any(s.kind == TRIG for kernel in self.kernels for s in kernel.statements)

    @property
    def factored(self) -> bool:
        """Returns whether prepare() factors M: M is constant and a loop solves M a = f."""
        return self.structure.mass_constant and any(k.solves for k in self.kernels)

    def __str__(self) -> str:
        lines = [f"program {self.equations.model.name}"]
        defaults = zip(self.parameter_names, self.defaults, strict=True)
        lines += [f"default {name} = {default.text}" for name, default in defaults]
        lines += [str(kernel) for kernel in (self.prepare, self.start, *self.kernels)]
        return "\n".join(lines)


@record
class LoopProgram:
    """The templates' context of a model with loops: strings, numbers and lists of them."""

    name: str
    context: dict[str, Any]


def operations_in(statements: Iterable[Statement]) -> Counter[str]:
    """Returns the counts of operations in the text of statements, without loads."""
    operations: Counter[str] = Counter()
    for statement in statements:
        if statement.kind != LOAD:
            operations.update(x for value in statement.values for x in value.operations)
        if statement.kind == TRIG:
            named = enumerate(statement.targets)
            operations.update(("sin", "cos")[i % 2] for i, name in named if name != "NULL")
    return operations


def operations_text(operations: Counter[str]) -> str:
    """Returns '31 operations: 5 +, 4 -, 20 *, 1 /, 1 sin', in a fixed order."""
    total = sum(operations.values())
    if not total:
        return "no operations"
    signs = ["+", "-", "*", "/", "neg"]
    names = [s for s in signs if s in operations]
    names += sorted(s for s in operations if s not in signs)
    shown = ", ".join(f"{operations[name]} {name}" for name in names)
    return f"{total} operation{'s' if total > 1 else ''}: {shown}"
