"""Where the work array of the functions has each number, and which entries of Jacobians are
nonzero."""

from __future__ import annotations

from pathlib import Path

from pkgen.back.c.program import Program
from pkgen.equations import Matrix
from pkgen.graph.graph import BIT, ZERO, Kind

HERE = Path(__file__).parent


class Places:
    """`at` has the first index of each array, `size` their sum; x, u, p, xdot and y are indices of
    single numbers. `follows` says which of x start with values that depend on parameters."""

    def __init__(self, program: Program, follows: list[bool]):
        self.equations = e = program.equations
        self.follows, self.blocks = follows, program.structure.mass_blocks
        n, nu, np, ny = (len(k) for k in (e.coordinates, e.inputs, e.parameters, e.observed))
        self.n, self.nu, self.nq = n, nu, e.own
        found = {"t": 1, "one": 1, "q": n, "v": n, "u": nu, "p": np, "a": n, "y": ny}
        found |= {"M": n * n, "r_q": n * n, "r_v": n * n, "r_t": n, "r_u": n * nu, "r_p": n * np}
        found |= {"out_d": ny * (2 * n + 1 + nu + np), "start_p": 2 * n * np}
        self.at, self.size = {}, 0
        for name, count in found.items():
            self.at[name] = self.size
            self.size += count
        places = {name: [*range(self.at[name], self.at[name] + k)] for name, k in found.items()}
        self.u, self.p, self.y = (places[name] for name in "upy")
        self.x = places["q"][: self.nq] + places["v"]
        self.xdot = places["v"][: self.nq] + places["a"]
        nodes = (*e.force, *sum(e.mass, ()), *e.observed)
        self.timed = any(e.graph.depends[node] & BIT[Kind.TIME] for node in nodes)

    def slopes_of_f(self, name: str) -> list[dict[int, int]]:
        """Returns for each column of dx'/d(name) the places of its nonzero entries by row."""
        e, nq = self.equations, self.nq
        by_t = tuple((node,) for node in e.linear.r_t)
        made = {
            "x": [("r_q", e.linear.r_q, range(nq)), ("r_v", e.linear.r_v, range(self.n))],
            "t": [("r_t", by_t, range(1))],
            "u": [self._whole("r_u", len(self.u))],
            "p": [self._whole("r_p", len(self.p))],
        }
        found = []
        for kernel, matrix, columns in made[name]:
            for j in columns:
                column = self._solved(kernel, matrix, j)
                if kernel == "r_v" and j < nq:
                    column[j] = self.at["one"]  # q' = v
                found.append(column)
        return found

    def _whole(self, kernel: str, count: int) -> tuple[str, Matrix, range]:
        return kernel, self.equations.sensitivity.get(kernel, ()), range(count)

    def _solved(self, kernel: str, matrix: Matrix, j: int) -> dict[int, int]:
        """Returns the places of column j of M^-1 `matrix`, by row of x'."""
        first, width = self.at[kernel] + j, len(matrix[0])
        return {
            self.nq + i: first + width * i
            for block in self.blocks
            if any(matrix[k][j] != ZERO for k in block)
            for i in block
        }

    def slopes_of_y(self, name: str) -> list[dict[int, int]]:
        n, nu = self.n, self.nu
        inputs = range(2 * n + 1, 2 * n + 1 + nu)
        columns = {"x": [*range(self.nq), *range(n, 2 * n)], "t": [2 * n], "u": inputs}
        columns["p"] = range(inputs.stop, inputs.stop + len(self.p))
        rows = range(len(self.y))
        return [self._entries("out_d", j, rows) for j in columns[name]]

    def slopes_of_x0(self, _: str) -> list[dict[int, int]]:
        rows = [*range(self.nq), *range(self.n, 2 * self.n)]
        found = [self._entries("start_p", j, rows) for j in range(len(self.p))]
        return [{i: at for i, at in column.items() if self.follows[i]} for column in found]

    def _entries(self, kernel: str, j: int, rows: list[int]) -> dict[int, int]:
        matrix, first = self.equations.sensitivity[kernel], self.at[kernel] + j
        width = len(matrix[0])
        return {i: first + width * row for i, row in enumerate(rows) if matrix[row][j] != ZERO}
