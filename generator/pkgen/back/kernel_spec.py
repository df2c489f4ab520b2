"""What a kernel is: its row in the table of `kernels.py`, and how its outputs are written."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from ..equations import Equations, Matrix, Row
from ..graph.graph import ZERO, Graph, Node, Op
from ..graph.solve import Pivots
from ..record import record
from .targets import CHECK, FILL, STORE, Output, Target

Hint = tuple[Node, str]
_FEW_ZEROS = 8  # of a matrix, each written out


@record
class KernelSpec:
    """`says` is the equation in the kernel's comment; `result` the type in C."""

    name: str
    says: str
    outputs: Callable[[Equations], tuple[Output, ...]]
    targets: Callable[[Equations], list[Target]]
    result: str = "void"
    exists: Callable[[Equations], bool] = lambda _: True
    kept: Callable[[Equations], Sequence[Node]] = lambda _: ()  # become locals wherever they occur
    given: tuple[str, ...] = ()  # vectors taken besides t, q, v and u
    second: str = "v"  # what is taken with q: rates, or "momenta"

    def hints(self, equations: Equations) -> Iterator[Hint]:
        """Names for values that mean something to a reader, if they become locals."""
        if self.name == "acceleration":
            yield from _named("D", tuple(pivot for pivot, _ in equations.pivots or ()))
        if equations.mass:
            for i, row in enumerate(equations.mass):
                for j in range(i + 1):
                    yield row[j], f"M_{j}_{i}"
        yield from _named("f", equations.force)
        yield from _named("p", equations.momenta)


def _named(stem: str, row: Row) -> Iterator[Hint]:
    for i, node in enumerate(row):
        yield node, f"{stem}_{i}"


def stores(name: str, row: Row) -> list[Target]:
    return [Target(STORE, f"{name}[{i}]", (node,)) for i, node in enumerate(row)]


def pivot_checks(graph: Graph, failure: str, pivots: Pivots) -> Iterator[Target]:
    """That each pivot is positive beside what it is small beside, where that is not known."""
    checked: set[tuple[Node, Node]] = set()
    for number, (pivot, beside) in enumerate(pivots):
        positive = graph.op[pivot] is Op.NUMBER and graph.data[pivot] > 0  # type: ignore[operator]
        if positive or (pivot, beside) in checked:
            continue
        checked.add((pivot, beside))
        nodes = (pivot,) if pivot == beside else (pivot, beside)
        text = "{0} > 0" if pivot == beside else "{0} > PK_PIVOT_MIN * {1}"
        yield Target(
            CHECK,
            f"PK_FAILED(PK_FAILURE_{failure}, {number})",
            nodes,
            text,
            operations=("*",) if len(nodes) > 1 else (),
        )


def vectors(
    name: str, says: str, rows: Callable[[Equations], dict[str, Row]], **more: Any
) -> KernelSpec:
    """A kernel that writes vectors, by the names of its outputs."""
    return KernelSpec(
        name,
        says,
        lambda e: tuple(Output(output, len(row), 1) for output, row in rows(e).items()),
        lambda e: [target for output, row in rows(e).items() for target in stores(output, row)],
        **more,
    )


def vector(
    name: str, says: str, output: str, row: Callable[[Equations], Row], **more: Any
) -> KernelSpec:
    return vectors(name, says, lambda e: {output: row(e)}, **more)


def optional(name: str, says: str, output: str, row: Callable[[Equations], Row]) -> KernelSpec:
    """A kernel that there is where there is something to write."""
    return vector(name, says, output, row, exists=lambda e: bool(row(e)))


def symmetric(
    name: str, says: str, matrix: Callable[[Equations], Matrix | None], **more: Any
) -> KernelSpec:
    return KernelSpec(
        name,
        says,
        lambda e: (square("M", e),),
        lambda e: matrix_stores("M", matrix(e), symmetric=True),
        **more,
    )


def matrix_stores(name: str, matrix: Matrix, symmetric: bool = False) -> list[Target]:
    """All entries; of a symmetric matrix the upper triangle, mirrored. Many zeros are written by
    a loop at the start."""
    columns = len(matrix[0])
    zeros = sum(node == ZERO for row in matrix for node in row)
    targets = []
    if zeros > _FEW_ZEROS:
        targets.append(Target(FILL, name, (), str(len(matrix) * columns)))
    for i, row in enumerate(matrix):
        for j in range(i if symmetric else 0, columns):
            if row[j] == ZERO and targets and targets[0].kind == FILL:
                continue
            mirrored = (f"{name}[{j * columns + i}]",) if symmetric and j > i else ()
            targets.append(Target(STORE, f"{name}[{i * columns + j}]", (row[j],), also=mirrored))
    return targets


def square(name: str, equations: Equations) -> Output:
    n = len(equations.coordinates)
    return Output(name, n, n)


def row_checks(equations: Equations) -> list[Target]:
    """That the rows of constraints do not depend on each other."""
    if equations.constraints is None:
        return []
    return list(pivot_checks(equations.graph, "CONSTRAINT", equations.constraints.pivots))
