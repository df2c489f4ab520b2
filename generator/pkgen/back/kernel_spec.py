"""The specification of a kernel, a row in the table of `kernels.py`, and its output statements."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from ..equations import Equations, Matrix, Row
from ..graph.graph import ZERO, Graph, Node, Op
from ..graph.solve import Pivots
from ..record import record
from .targets import CHECK, FILL, MIRROR, RETURN, STORE, Output, Target

Hint = tuple[Node, str]
_FEW_ZEROS = 8  # In a matrix with more zeros a loop stores the zeros.
_FEW_ROWS = 6  # In a symmetric matrix with more rows a loop copies entries across the diagonal.


@record
class KernelSpec:
    """The specification of a kernel, a generated C function. `values` returns {output: its nodes},
    or one node if the kernel returns a pk_real. A model for which no output has nodes lacks the
    kernel. `says` is the comment in C, `result` the return type in C."""

    name: str
    says: str
    values: Callable[[Equations], Mapping[str, Row | Matrix | None] | None]
    result: str = "void"
    checks: Callable[[Equations], Iterable[Target]] = lambda _: ()  # made before the first store
    kept: Callable[[Equations], Sequence[Node]] = lambda _: ()  # Nodes that become local variables.
    given: tuple[str, ...] = ()  # Vector arguments after t, q, v and u.
    second: str = "v"  # The vector argument after q: "v" or "momenta".
    symmetric: bool = False
    copies: bool = (
        False  # whether equal entries, such as mixed second derivatives, are computed once
    )

    def exists(self, e: Equations) -> bool:
        return any((self.values(e) or {}).values())

    def outputs(self, e: Equations) -> tuple[Output, ...]:
        if self.result == "pk_real":
            return ()
        found = self.values(e).items()
        return tuple(Output(k, len(x), len(x[0]) if _is_matrix(x) else 1) for k, x in found)

    def targets(self, e: Equations) -> list[Target]:
        values = self.values(e)
        if self.result == "pk_real":
            return [Target(RETURN, "", row) for row in values.values()]
        if self.name == "acceleration" and e.acceleration is None:
            return []  # A loop solves M a = f instead.
        found = list(self.checks(e))
        for name, x in values.items():
            if _is_matrix(x):
                found += matrix_stores(name, x, self.symmetric)
            else:
                found += [Target(STORE, f"{name}[{i}]", (node,)) for i, node in enumerate(x)]
        return _copied(found) if self.copies else found

    def hints(self, equations: Equations) -> Iterator[Hint]:
        """Yields readable names (D_i, M_i_j, f_i, p_i) for nodes that may become locals."""
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


def pivot_checks(graph: Graph, failure: str, pivots: Pivots) -> Iterator[Target]:
    """Yields a check that each pivot is positive relative to its reference size; a pivot known to
    be positive needs no check."""
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


def _copied(targets: list[Target]) -> list[Target]:
    places: dict[Node, list[str]] = {}
    for target in targets:
        for node in target.nodes:
            places.setdefault(node, []).append(target.where)
    fills = [target for target in targets if target.kind == FILL]
    return fills + [
        Target(STORE, where, (node,), also=tuple(copies))
        for node, (where, *copies) in places.items()
    ]


def _is_matrix(x: Row | Matrix) -> bool:
    return bool(x) and isinstance(x[0], tuple)


def matrix_stores(name: str, matrix: Matrix, symmetric: bool = False) -> list[Target]:
    """Returns the stores of all entries of a matrix. For a symmetric matrix only the entries on and
    above the diagonal are computed and then copied, by a loop if the matrix is large. If many
    entries are zero, a loop first fills the matrix with 0."""
    columns = len(matrix[0])
    zeros = sum(node == ZERO for row in matrix for node in row)
    small = symmetric and columns <= _FEW_ROWS
    targets = []
    if zeros > _FEW_ZEROS:
        targets.append(Target(FILL, name, (), str(len(matrix) * columns)))
    for i, row in enumerate(matrix):
        for j in range(i if symmetric else 0, columns):
            if row[j] == ZERO and targets and targets[0].kind == FILL:
                continue
            mirrored = (f"{name}[{j * columns + i}]",) if small and j > i else ()
            targets.append(Target(STORE, f"{name}[{i * columns + j}]", (row[j],), also=mirrored))
    if symmetric and not small:
        targets.append(Target(MIRROR, name, (), str(columns)))
    return targets
