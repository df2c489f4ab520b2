"""Kernels as C functions: their statements, and the functions into which long ones are split."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import groupby

from ..kernel_spec import KernelSpec
from ..kernels import kernel as spec_of
from ..targets import CHECK, LOAD, LOCAL, TRIG
from .chunk import ARGUMENTS
from .program import Block, Kernel, Statement, operations_text
from .tree import Function, If, Node, Text

TYPES = {
    "t": "pk_real t",
    **{x: f"const pk_real *{x}" for x in ("q", "v", "momenta", "u", "a")},
    "w": "pk_real *w",
}
_PREPARE = KernelSpec("prepare", "", lambda _: {}, "int")  # no row of KERNELS: it has no outputs
_ROOM = 76  # The largest length of the declarations on one line.
_GROUP = {LOAD: 0, CHECK: 2}  # kind of statement -> its group; other kinds are in group 1


def statements(
    found: Iterable[Statement], lane: str = "", flag: str = "bad", uniform: Collection[str] = ()
) -> Iterator[Node]:
    """Yields a kernel's C statements. Code that is shared by the SIMD lanes has a constant of the
    enum pk_pass, with the C text `lane`; plain code has "". With such a constant, an angle that
    the inline sine cannot handle sets the C variable `flag`, and a failed check sets `bad`; code
    for a single state then returns. The checks `uniform` contain parameters alone; within a loop
    over lanes they are omitted, since code after the loop makes them."""
    for s in found:
        if s.kind == TRIG:
            yield f"pk_real {', '.join(s.defines)};"
            yield sincos(s, lane, flag)
        elif s.kind == CHECK and lane:
            noted = f"bad |= (pk_bits)!({s.text});"
            yield If("pass != PK_IN_LANE", [noted]) if s.text in uniform else noted
            yield If("pass >= PK_ONCE && bad", [f"return {s.target};"])
        else:
            yield str(s)


def sincos(s: Statement, lane: str, flag: str) -> Node:
    """Returns the call for the sine and cosine of one or two angles. If `lane` is not "", a failure
    sets the C variable `flag`."""
    places = ["NULL" if name == "NULL" else f"&{name}" for name in s.targets]
    function = ("pk_sincos_pass" if lane else "pk_sincos") + "_2" * (len(s.values) > 1)
    call = f"{function}({', '.join([*([lane] if lane else []), *s.values, *places])})"
    return f"{flag} |= {call};" if lane else f"{call};"


def grouped(
    found: Sequence[Statement], lane: str = "", uniform: Collection[str] = ()
) -> Iterator[Node]:
    """Yields C statements, with blank lines between loads, computations and checks."""
    for k, (_, several) in enumerate(groupby(found, lambda s: _GROUP.get(s.kind, 1))):
        if k:
            yield ""
        for local, found_here in groupby(several, lambda s: s.kind in (LOAD, LOCAL)):
            run = list(found_here)
            yield from _declared(run) if local else statements(run, lane, "bad", uniform)


def _declared(found: Iterable[Statement]) -> Iterator[Node]:
    """Yields declarations of constants, several in one declaration."""
    line = ""
    for s in found:
        one = f"{s.target} = {s.text}"
        if line and len(line) + len(one) > _ROOM:
            yield f"const pk_real {line};"
            line = ""
        line += f", {one}" if line else one
    yield f"const pk_real {line};"


def unused(names: Iterable[str]) -> list[Node]:
    text = ", ".join(f"(void){name}" for name in names)
    return [f"{text};"] if text else []


class KernelCode:
    """A kernel of a model as C: its declaration and its functions."""

    def __init__(self, model: str, kernel: Kernel, free: str = ""):
        """Where the condition `free` holds, the kernel NAME_free is called in its place."""
        self.model, self.kernel, self.free = model, kernel, free
        self.spec = _PREPARE if kernel.name == "prepare" else spec_of(kernel.name)
        self.name = f"{model}_{kernel.name}"

    @property
    def vectors(self) -> list[str]:
        """Returns the names of the first two vector arguments: q, then v or momenta."""
        return ["q", self.spec.second]

    @property
    def unused(self) -> list[str]:
        arguments = ["p", "t", *self.vectors, "u", *self.spec.given]
        arguments = {"start": ["p"], "prepare": []}.get(self.kernel.name, arguments)
        names = [] if self.kernel.solves else [a for a in arguments if a not in self.kernel.uses]
        return names + [output.name for output in self.kernel.outputs if not output.rows]

    def arguments(self, restrict: str = "") -> str:
        parts = [f"const struct {self.model}_params *p", "pk_real t"]
        parts += [f"const pk_real *{x}" for x in (*self.vectors, "u", *self.spec.given)]
        parts += [f"pk_real *{restrict}{output.name}" for output in self.kernel.outputs]
        return ", ".join(parts)

    def declaration(self, restrict: str = "") -> str:
        return f"{self.kernel.result} {self.name}({self.arguments(restrict)})"

    @property
    def says(self) -> str:
        operations = operations_text(self.kernel.operations)
        return f"{self.spec.says}. {operations[0].upper()}{operations[1:]}."

    def parts(self) -> Iterator[Function]:
        """Yields functions for all blocks of a long kernel except the last one."""
        of = self.kernel
        work = "; w hands values on" if of.work else ""
        for number, block in enumerate(of.blocks[:-1], 1):
            result, end = ("int", ["return 0;"]) if block.checks else ("void", [])
            yield Function(
                f"{self.model}_APART static {result} {self.name}_{number}({self._typed(block)})",
                [*grouped(block.statements), *end],
                f"Part {number} of {self.name}{work}.",
            )

    def _inputs(self, block: Block) -> tuple[list[str], list[str]]:
        outputs = [o.name for o in self.kernel.outputs if o.name in block.uses]
        return [a for a in ARGUMENTS if a in block.uses and a not in outputs], outputs

    def _typed(self, block: Block) -> str:
        arguments, outputs = self._inputs(block)
        const = "" if self.kernel.name == "prepare" else "const "
        types = {"p": f"{const}struct {self.model}_params *p", **TYPES}
        typed = [types[a] for a in arguments]
        return ", ".join(typed + [f"pk_real *PK_RESTRICT {output}" for output in outputs])

    def body(self) -> Iterator[Node]:
        """Yields the body: the work array, calls of the functions of parts(), the last block."""
        of, parts = self.kernel, self.kernel.blocks[:-1]
        if self.free:
            outputs = ", ".join(output.name for output in of.outputs)
            call = f"{self.name}_free(p, t, q, v, u, {outputs})"
            void = of.result == "void"
            yield If(self.free, [f"{call};", "return;"] if void else [f"return {call};"])
        if of.work and of.name != "prepare":
            yield f"pk_real w[{of.work}];"
        if any(block.checks for block in parts):
            yield "int status;"
        if parts:
            yield ""
        for number, block in enumerate(parts, 1):
            arguments, outputs = self._inputs(block)
            call = f"{self.name}_{number}({', '.join(arguments + outputs)})"
            if block.checks:
                yield If(f"(status = {call}) != 0", ["return status;"])
            else:
                yield f"{call};"
        if parts:
            yield ""
        yield from unused(self.unused)
        if self.unused:
            yield ""
        yield from grouped(of.blocks[-1].statements)

    def definition(self, dense: str) -> Function:
        """Returns the kernel's C function. Its body is `dense`, which solves M a = f (mass matrix
        M, accelerations a) by a loop, if the kernel has no statements of its own."""
        body: list[Node] = [Text(dense)] if self.kernel.solves else [*self.body()]
        if self.kernel.result == "int" and not self.kernel.solves:
            body.append("return 0;")
        return Function(self.declaration("PK_RESTRICT "), body, self.says)
