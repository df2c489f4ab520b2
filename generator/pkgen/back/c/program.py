"""What `lower` hands on: straight-line code as text, ready for the templates.

An expression is text already (`expressions.py` writes it); everything around it, from
declarations to comments, belongs to the templates. Nothing here refers to the graph.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import field
from typing import NamedTuple

from ...equations import Equations, Structure
from ...record import record
from .expressions import count_operations

LANES = ("lanes", "members")  # many states side by side, with one set of parameters or many

# The kinds of a statement, and how each is shown in a dump.
LOCAL = "local"  # const pk_real TARGET = TEXT;
TRIG = "trig"  # sine and cosine into the names in TARGET; NULL: not needed. TEXT: one angle, or
# two with a semicolon between
LOAD = "load"  # the same, of an argument: const pk_real theta1 = q[0];
STORE = "store"  # TARGET = TEXT;
FILL = "fill"  # for all k < TEXT: TARGET[k] = 0;
CHECK = "check"  # if (!(TEXT)) return TARGET;
RETURN = "return"  # return TEXT;
_SHOWN = {
    LOCAL: "{target} = {text}",
    TRIG: "{target} = sincos {text}",
    LOAD: "{target} = {text}",
    STORE: "{target} := {text}",
    FILL: "{target}[0..{text} - 1] := 0",
    CHECK: "unless {text}: return {target}",
    RETURN: "return {text}",
}


class Statement(NamedTuple):
    kind: str
    target: str
    text: str

    @property
    def defines(self) -> tuple[str, ...]:
        """The local constants that it makes."""
        if self.kind == TRIG:
            return tuple(name for name in self.target.split() if name != "NULL")
        return (self.target,) if self.kind in (LOCAL, LOAD) else ()

    def __str__(self) -> str:
        return _SHOWN[self.kind].format(target=self.target, text=self.text)


@record
class Block:
    """A run of statements. All but a kernel's last block become functions of their own, which
    hand values on through a work array: compilers are superlinear on straight-line code."""

    statements: tuple[Statement, ...]
    uses: frozenset[str]  # of the arguments p t q v u w and the outputs

    @property
    def checks(self) -> bool:
        return any(s.kind == CHECK for s in self.statements)


@record
class Output:
    """An array that a kernel writes; `shape` is its dimensions, each with its C constant."""

    name: str
    rows: int
    columns: int  # 1 for a vector

    @property
    def length(self) -> int:
        return self.rows * self.columns


@record
class Kernel:
    name: str
    result: str  # the C type it returns
    outputs: tuple[Output, ...]
    blocks: tuple[Block, ...]
    work: int  # length of the array through which blocks hand on values
    operations: Counter[str] = field(default_factory=Counter)
    solves: bool = False  # acceleration by a loop over M and f, without statements

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

    index: int  # of the parameter
    statements: tuple[Statement, ...]  # locals that the value needs
    text: str


@record
class Interval:
    """Where one parameter may lie; None is infinite."""

    statements: tuple[Statement, ...]  # locals that the bounds need
    lo: str | None
    hi: str | None


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
    parameter_names: tuple[str, ...]  # of each scalar parameter in C: "m1", "k[2]"
    defaults: tuple[Assignment, ...]
    bounds: tuple[Interval, ...]
    prepare: Kernel  # fills the hoisted constants
    hoisted: int  # their number
    start: Kernel
    quadrature_start: Kernel
    kernels: tuple[Kernel, ...]
    float_too: bool  # whether float can hold its constants
    helpers: tuple[str, ...]  # functions that the C file must define: "min", "step", ...
    lanes: tuple[str, ...] = ()  # forms of the acceleration of many states: of LANES

    def kernel(self, name: str) -> Kernel | None:
        return next((k for k in self.kernels if k.name == name), None)

    @property
    def has_sincos(self) -> bool:
        """Whether any kernel calls the inline pair."""
        return any(s.kind == TRIG for kernel in self.kernels for s in kernel.statements)

    @property
    def factored(self) -> bool:
        """Whether prepare() factors M, which is constant: by a loop, as the acceleration solves."""
        return self.structure.mass_constant and any(k.solves for k in self.kernels)

    def __str__(self) -> str:
        lines = [f"program {self.equations.model.name}"]
        lines += [f"default {self.parameter_names[a.index]} = {a.text}" for a in self.defaults]
        lines += [str(kernel) for kernel in (self.prepare, self.start, *self.kernels)]
        return "\n".join(lines)


def operations_in(statements: Iterable[Statement], prefix: str) -> Counter[str]:
    """Operations of statements; `prefix` starts the names of the model's own helper functions."""
    statements = [s for s in statements if s.kind != LOAD]
    operations = count_operations((s.text for s in statements), prefix)
    for statement in statements:
        if statement.kind == TRIG:
            named = enumerate(statement.target.split())
            operations.update(("sin", "cos")[i % 2] for i, name in named if name != "NULL")
    return operations


def operations_text(operations: Counter[str]) -> str:
    """'31 operations: 5 +, 4 -, 20 *, 1 /, 1 sin' in a fixed order."""
    total = sum(operations.values())
    if not total:
        return "no operations"
    signs = ["+", "-", "*", "/", "neg"]
    names = [s for s in signs if s in operations]
    names += sorted(s for s in operations if s not in signs)
    shown = ", ".join(f"{operations[name]} {name}" for name in names)
    return f"{total} operation{'s' if total > 1 else ''}: {shown}"
