"""Makes a C file and its library of external functions for CasADi: x' = f(x, u, p), the outputs,
the start, and their Jacobians by CasADi's names, with their sparsity.

x has the coordinates q, then v: rates, body rates, first-order variables. With r = f - M a, each
da/dx is M^-1 dr/dx at constant a; the C solves for it in place. A row of M^-1 dr/dx has the entries
that all rows of dr/dx in the same block of M have.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pkgen.back.c.ctext import comment, paragraph
from pkgen.back.exported import Exported, Host
from pkgen.back.host.data import states
from pkgen.back.library import TARGETS, library, this_machine
from pkgen.back.templates import filled
from pkgen.graph.graph import BIT, ZERO, Kind
from pkgen.record import record
from pkgen.version import __version__

from ..standalone.plain import plain

KERNELS = frozenset(
    ("acceleration", "linear", "mass", "observe", "r_u", "r_p", "out_d", "start_p")
) | {"energy", "event"}  # a run without steps describes the model; its columns need these


@record
class Value:
    """A vector or matrix: its shape, and its nonzero entries as (column, row, index in the work
    array), in this order."""

    name: str
    rows: int
    columns: int
    entries: tuple[tuple[int, int, int], ...]

    @property
    def sparsity(self) -> list[int]:
        """Returns the compressed columns in CasADi's format."""
        ends = [sum(column < k for column, _, _ in self.entries) for k in range(self.columns + 1)]
        return [self.rows, self.columns, *ends, *(row for _, row, _ in self.entries)]


def _vector(name: str, places: list[int]) -> Value:
    return Value(name, len(places), 1, tuple((0, row, at) for row, at in enumerate(places)))


class Places:
    """The work array: `at` has the first index of each array, `size` is their sum. `nq` and `n` are
    the lengths of q and v, `follows` says which of x start with values that depend on
    parameters."""

    def __init__(self, model: Exported, follows: list[bool]):
        e, blocks = model.program.equations, model.program.structure.mass_blocks
        self.n, self.nq = n, nq = len(e.coordinates), e.own
        self.nu, self.np = nu, np = len(e.inputs), len(e.parameters)
        ny = len(e.observed)
        sizes = {"t": 1, "one": 1, "q": n, "v": n, "u": nu, "p": np, "a": n, "y": ny}
        sizes |= {"M": n * n, "r_q": n * n, "r_v": n * n, "r_t": n, "r_u": n * nu, "r_p": n * np}
        self.shown = [y["index"] for y in model.description["outputs"] if not y["hidden"]]
        sizes |= {"out_d": ny * (2 * n + 1 + nu + np), "start_p": 2 * n * np}
        self.at, self.size = {}, 0
        for name, size in sizes.items():
            self.at[name] = self.size
            self.size += size
        nodes = (*e.force, *sum(e.mass, ()), *(e.observed[k] for k in self.shown))
        self.timed = any(e.graph.depends[node] & BIT[Kind.TIME] for node in nodes)
        u, p = 2 * n + 1, 2 * n + 1 + nu
        starts = [*range(nq), *range(n, 2 * n)]  # q and v in the rows and columns of kernels
        self.matrices = {"r_q": e.linear.r_q, "r_v": e.linear.r_v, **(e.sensitivity or {})}
        self.matrices["r_t"] = tuple((node,) for node in e.linear.r_t)
        # Of each function, by input: the kernel and the columns in it.
        self.columns = {
            "f": {
                "x": [("r_q", range(nq)), ("r_v", range(n))],
                **{one: [(f"r_{one}", range(k))] for one, k in (("u", nu), ("p", np), ("t", 1))},
            },
            "y": {
                "x": [("out_d", starts)],
                "u": [("out_d", range(u, p))],
                "p": [("out_d", range(p, p + np))],
                "t": [("out_d", range(2 * n, u))],
            },
            "x0": {"p": [("start_p", range(np))]},
        }
        # Of each function: its row, the kernel's row, and the rows of which it is made.
        self.rows = {
            "f": [(nq + i, i, block) for block in blocks for i in block],
            "y": [(i, k, (k,)) for i, k in enumerate(self.shown)],
            "x0": [(i, k, (k,)) for i, k in enumerate(starts) if follows[i]],
        }

    def places(self, *parts: tuple[str, int]) -> list[int]:
        return [self.at[name] + i for name, count in parts for i in range(count)]

    def vector(self, name: str, *parts: tuple[str, int]) -> Value:
        return _vector(name, self.places(*parts))

    def jacobian(self, function: str, output: Value, by: Value) -> Value:
        found, column = [], 0
        for kernel, columns in self.columns[function][by.name]:
            for j in columns:
                if kernel == "r_v" and j < self.nq:
                    found.append((column, j, self.at["one"]))  # q' = v
                matrix = self.matrices[kernel]
                for row, k, made_of in self.rows[function]:
                    if any(matrix[i][j] != ZERO for i in made_of):
                        found.append((column, row, self.at[kernel] + k * len(matrix[0]) + j))
                column += 1
        return Value(f"jac_{output.name}_{by.name}", output.rows, column, tuple(sorted(found)))

    def functions(self) -> Iterator[tuple[str, list[Value], list[Value]]]:
        """Yields the name, the inputs and the outputs of each function, a Jacobian after its own.
        CasADi gives a Jacobian the function's output too, which it does not read."""
        x, u, p, t = (
            self.vector("x", ("q", self.nq), ("v", self.n)),
            *(self.vector(name, (name, k)) for name, k in (("u", self.nu), ("p", self.np))),
            self.vector("t", ("t", 1)),
        )
        given = [x, u, p, *([t] if self.timed else [])]
        made = {"f": (given, self.vector("xdot", ("v", self.nq), ("a", self.n)))}
        if self.shown:
            made["y"] = given, _vector("y", [self.at["y"] + k for k in self.shown])
        made["x0"] = [p], self.vector("x0", ("q", self.nq), ("v", self.n))
        for name, (inputs, output) in made.items():
            yield name, inputs, [output]
            unread = Value(f"out_{output.name}", output.rows, 1, ())
            blocks = [self.jacobian(name, output, one) for one in inputs]
            yield f"jac_{name}", [*inputs, unread], blocks
        yield "p0", [], [p]


def make(model: Exported) -> dict[str, bytes]:
    name, program, x = model.name, model.program, states(model.description)
    e, w = program.equations, Places(model, [item["follows"] for item in x])
    header, source = (plain(model.files[f"{name}.{k}"], {"PK_RUNTIME": False}) for k in "hc")
    lists = {
        "x": [(item["name"], item["unit"]) for item in x],
        "u": [(q.name, q.unit) for q in e.inputs],
        "p": [(slot.quantity.name, slot.quantity.unit) for slot in e.parameters],
        "y": [(e.observed_names[k].name, e.observed_names[k].unit) for k in w.shown],
    }
    text = filled(
        Path(__file__).parent / "templates",
        "casadi.c.j2",
        name=name,
        version=__version__,
        code=header + "\n" + source.replace(f'#include "{name}.h"\n', "", 1),
        lists=[
            paragraph(comment(f"{key}: {', '.join(f'{a} [{b}]' if b else a for a, b in found)}"))
            for key, found in lists.items()
            if found
        ],
        w=w,
        kernels=[kernel.name for kernel in program.kernels],
        parameters=program.parameter_names,
        tables=program.tables,
        values=[repr(float(item["value"])) for item in model.description["parameters"]],
        starts=[
            (at, repr(float(item["value"])))
            for at, item in zip(w.places(("q", w.nq), ("v", w.n)), x, strict=True)
            if not item["follows"] and item["value"] is not None
        ],
        functions=list(w.functions()),
    )
    made = library({f"{name}_casadi.c": text}, "f y x0 p0 jac_")
    suffix = TARGETS[this_machine()].suffix
    return {f"{name}_casadi.c": text.encode(), f"{name}_casadi{suffix}": made}


CASADI = Host(
    "casadi",
    "x' = f(x, u, p) with Jacobians as external functions",
    make,
    how=lambda _: {"kernels": KERNELS},
)
