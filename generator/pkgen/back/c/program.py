"""The result of `lower`: straight-line code as text, ready for the templates.

Expressions are C text, made by `expressions.py`; templates and `tree.py` make everything else, from
declarations to comments. Nothing here refers to the expression graph.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import field
from typing import Any, NamedTuple

from ...equations import AnyEquations, Equations
from ...middle.structure import Structure
from ...model import Table
from ...record import record
from ..targets import ADD, CHECK, FILL, LOAD, LOCAL, MIRROR, RETURN, STORE, TRIG, Output
from .constants import Constant
from .expressions import Code, base
from .jet_kernel import Jet

LANES = ("lanes", "members")  # Many states with common or own parameters.

_FORMS = {
    **dict.fromkeys((LOCAL, LOAD), "const pk_real {target} = {text};"),
    TRIG: "{target} = sincos {text};",  # kernel_code.py writes a call in C
    STORE: "{target} = {text};",
    ADD: "{target} += {text};",
    FILL: "for (size_t k = 0; k < {text}; k++)\n    {target}[k] = 0;",
    MIRROR: "for (size_t i = 1; i < {text}; i++)\n    for (size_t j = 0; j < i; j++)\n"
    "        {target}[i * {text} + j] = {target}[j * {text} + i];",
    CHECK: "if (!({text}))\n    return {target};",
    RETURN: "return {text};",
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
        """Returns the local variables that the statement declares."""
        made = self.targets if self.kind in (LOCAL, LOAD, TRIG) else ()
        return tuple(name for name in made if name != "NULL")

    def __str__(self) -> str:
        return _FORMS[self.kind].format(target=self.target, text=self.text)


@record
class Block:
    """A sequence of statements. A long kernel has several blocks; all except the last become C
    functions, to limit compile time. These functions pass values through a work array."""

    statements: tuple[Statement, ...]
    uses: frozenset[str]  # the arguments and outputs that occur in the statements

    @property
    def checks(self) -> bool:
        return any(s.kind == CHECK for s in self.statements)


@record
class Kernel:
    name: str
    result: str  # C type of the return value
    outputs: tuple[Output, ...]
    blocks: tuple[Block, ...]
    work: int  # Length of the array in which blocks pass values.
    operations: Counter[str] = field(default_factory=Counter)
    solves: bool = False  # A loop solves M a = f; the kernel has no statements.

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
class Interval:
    """The bounds of one parameter, as C text. A bound that is None is infinite."""

    statements: tuple[Statement, ...]  # Declarations that the bounds need.
    lo: str | None
    hi: str | None

    @property
    def ends(self) -> tuple[str, str]:
        return self.lo or "-PK_INFINITY", self.hi or "PK_INFINITY"


@record
class Field:
    """A member of struct NAME_params: a parameter, or an array of `length` family members."""

    c_name: str
    length: int  # 0 for a single parameter.
    first: int  # Index of the parameter or of the first member.


@record
class Program:
    equations: Equations
    structure: Structure
    fields: tuple[Field, ...]
    parameter_names: tuple[str, ...]  # C text of each scalar parameter: "m1", "k[2]"
    defaults: tuple[tuple[Statement, ...], ...]  # the assignment of each parameter's default
    bounds: tuple[Interval, ...]
    prepare: Kernel  # the function that computes the constants
    constants: tuple[Constant, ...]  # The hoisted constants.
    start: Kernel
    kernels: tuple[Kernel, ...]
    float_too: bool  # whether all constants fit in C's float
    helpers: tuple[str, ...]  # Functions that <math.h> lacks: "min", "step", ...
    lanes: tuple[str, ...] = ()  # A subset of LANES.
    tables: tuple[tuple[str, Table], ...] = ()  # with the name of its member of NAME_params
    jet: Jet | None = None  # the functions of Taylor coefficients, if they are asked for
    plain: bool = False  # C to be embedded, without the runtime's tables.

    def kernel(self, name: str) -> Kernel | None:
        return next((k for k in self.kernels if k.name == name), None)

    @property
    def all_kernels(self) -> tuple[Kernel, ...]:
        return self.prepare, self.start, *self.kernels

    @property
    def has_sincos(self) -> bool:
        """Returns whether a kernel calls the runtime's inline function of sine and cosine."""
        return any(s.kind == TRIG for kernel in self.kernels for s in kernel.statements)

    @property
    def factored(self) -> bool:
        """Returns whether prepare() factors M: if it is constant and a loop solves M a = f."""
        return self.structure.mass_constant and any(k.solves for k in self.kernels)

    def __str__(self) -> str:
        lines = [f"program {self.equations.model.name}"]
        defaults = zip(self.parameter_names, self.defaults, strict=True)
        lines += [f"default {name} = {default[-1].text}" for name, default in defaults]
        lines += [str(kernel) for kernel in (self.prepare, self.start, *self.kernels)]
        return "\n".join(lines)


@record
class FamilyProgram:
    """The C of equations that are kept for families of any length, as template variables: strings,
    numbers and lists of these."""

    equations: AnyEquations
    context: dict[str, Any]
    kernels = ()  # Their operations are not counted one by one, but a member.


def operations_in(statements: Iterable[Statement]) -> Counter[str]:
    """Returns the numbers of operations in statements, except loads."""
    operations: Counter[str] = Counter()
    for statement in statements:
        if statement.kind != LOAD:
            operations.update(x for value in statement.values for x in value.operations)
        if statement.kind == TRIG:
            named = enumerate(statement.targets)
            operations.update(("sin", "cos")[i % 2] for i, name in named if name != "NULL")
    return operations


def operations_text(operations: Counter[str]) -> str:
    """Returns the counts as '31 operations: 5 +, 4 -, 20 *, 1 /, 1 sin', in a fixed order."""
    total = sum(operations.values())
    if not total:
        return "no operations"
    signs = ["+", "-", "*", "/", "neg"]
    names = [s for s in signs if s in operations]
    names += sorted(s for s in operations if s not in signs)
    shown = ", ".join(f"{operations[name]} {name}" for name in names)
    return f"{total} operation{'s' if total > 1 else ''}: {shown}"
