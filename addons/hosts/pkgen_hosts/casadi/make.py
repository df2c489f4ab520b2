"""Makes a C file and its library of external functions for CasADi: x' = f(x, u, p), the outputs,
the start, and their Jacobians by CasADi's names, with their sparsity.

x has the coordinates, then v: rates, body rates, first-order variables. With r = f - M a, each
da/dx is M^-1 dr/dx at constant a; the C solves for it in place. A row of M^-1 dr/dx has the entries
that the rows of dr/dx in the same block of M have.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pkgen.back.c.ctext import comment, paragraph
from pkgen.back.exported import Exported, Host
from pkgen.back.host.data import states
from pkgen.back.library import TARGETS, library, this_machine
from pkgen.back.templates import filled
from pkgen.record import record
from pkgen.version import __version__

from ..standalone.plain import plain
from .places import HERE, Places

KERNELS = frozenset(
    ("acceleration", "linear", "mass", "observe", "r_u", "r_p", "out_d", "start_p")
) | {"energy", "event"}  # a run without steps describes the model; its columns need these
SHOWN = "f y x0 p0 jac_"  # what the names of the library begin with


@record
class Value:
    """A vector or a matrix of a function: its name, its shape, and its nonzero entries column by
    column as (row, column, index in the work array)."""

    name: str
    rows: int
    columns: int
    entries: tuple[tuple[int, int, int], ...]

    @property
    def sparsity(self) -> list[int]:
        """Returns the compressed columns as CasADi takes them."""
        starts = [sum(column < k for _, column, _ in self.entries) for k in range(self.columns + 1)]
        return [self.rows, self.columns, *starts, *(row for row, _, _ in self.entries)]

    @property
    def places(self) -> list[int]:
        return [place for _, _, place in self.entries]


@record
class Function:
    name: str
    inputs: tuple[Value, ...]
    outputs: tuple[Value, ...]


def _vector(name: str, places: Iterable[int]) -> Value:
    entries = tuple((row, 0, place) for row, place in enumerate(places))
    return Value(name, len(entries), 1, entries)


def _functions(w: Places) -> Iterator[Function]:
    """Yields each function, followed by its Jacobian."""
    x, u, p, t = (
        _vector(name, places)
        for name, places in (("x", w.x), ("u", w.u), ("p", w.p), ("t", [w.at["t"]]))
    )
    given = (x, u, p, *([t] if w.timed else []))
    yield from _with_jacobian("f", given, _vector("xdot", w.xdot), w.slopes_of_f)
    if w.y:
        yield from _with_jacobian("y", given, _vector("y", w.y), w.slopes_of_y)
    yield from _with_jacobian("x0", (p,), _vector("x0", w.x), w.slopes_of_x0)
    yield Function("p0", (), (_vector("p", w.p),))


def _with_jacobian(name, inputs, output, slopes) -> Iterator[Function]:
    """Yields a function and its Jacobian. `slopes(input)` returns for each column the places of its
    nonzero entries by row."""
    yield Function(name, inputs, (output,))
    nominal = Value(f"out_{output.name}", output.rows, 1, ())  # CasADi gives the output; not read
    blocks = []
    for one in inputs:
        columns = slopes(one.name)
        entries = ((i, j, found[i]) for j, found in enumerate(columns) for i in sorted(found))
        blocks.append(Value(f"jac_{output.name}_{one.name}", output.rows, one.rows, (*entries,)))
    yield Function(f"jac_{name}", (*inputs, nominal), (*blocks,))


def make(model: Exported) -> dict[str, bytes]:
    name, of, program = model.name, model.description, model.program
    e = program.equations
    y = states(of)
    w = Places(program, [item["follows"] for item in y])
    header, source = (
        plain(model.files[f"{name}.{end}"], {"PK_RUNTIME": False}) for end in ("h", "c")
    )
    lists = {
        "x": [(item["name"], item["unit"]) for item in y],
        "u": [(q.name, q.unit) for q in e.inputs],
        "p": [(slot.quantity.name, slot.quantity.unit) for slot in e.parameters],
        "y": [(q.name, q.unit) for q in e.observed_names],
    }
    named = [
        paragraph(f"{key}: " + comment(", ".join(f"{a} [{b}]" if b else a for a, b in found)))
        for key, found in lists.items()
        if found
    ]
    text = filled(
        HERE / "templates",
        "casadi.c.j2",
        name=name,
        version=__version__,
        header=header,
        source=source.replace(f'#include "{name}.h"\n', "", 1),
        named=named,
        w=w,
        kernels=[kernel.name for kernel in program.kernels],
        parameters=program.parameter_names,
        tables=bool(program.tables),
        numbers=[repr(float(item["value"])) for item in of["parameters"]],
        starts=[
            (place, repr(float(item["value"])))
            for place, item in zip(w.x, y, strict=True)
            if not item["follows"] and item["value"] is not None
        ],
        functions=list(_functions(w)),
    )
    path = f"{name}_casadi"
    made = library({f"{path}.c": text}, SHOWN)
    return {f"{path}.c": text.encode(), f"{path}{TARGETS[this_machine()].suffix}": made}


CASADI = Host(
    "casadi",
    "x' = f(x, u, p) with Jacobians, as external functions",
    make,
    how=lambda _: {"kernels": KERNELS},
)
