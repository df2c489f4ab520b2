"""The C text of terms of models with families: their functions, and tables of them, which are read
by members_list.h and members_band.h."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable

from ....graph.affine import ROW, Affine
from ....middle.families.indexed_ir import Cell
from ..kernel_code import statements
from ..program import Statement
from ..tree import Function, Loop, Node, Scope, rendered
from .kernels import Kernel, Terms, members_in
from .numbers import Numbers
from .readers import Readers, declared

# Parameters and hoisted constants in C: p->k, p->c_[3].
_CONSTANT = re.compile(r"\bp->(?:c_\[(\d+)\]|(\w+))(?![\w\[])")


def filled(rows: Iterable[str], indent: int = 4) -> str:
    """Returns rows of a table, as many in a line as fit."""
    text = ", ".join(rows).replace("{ ", "{")
    return textwrap.fill(text, 98, initial_indent=" " * indent, subsequent_indent=" " * indent)


def table(kind: str, name: str, rows: list[str]) -> str:
    return f"static const {kind} {name}[{len(rows)}] = {{\n{filled(rows)}}};\n" if rows else ""


class KernelText:
    """Writes the terms of one model, which compute at most `block` members at a time."""

    def __init__(self, name: str, numbers: Numbers, readers: Readers, block: int):
        self.name, self.numbers, self.readers, self.block = name, numbers, readers, block
        self._written: set[str] = set()  # the functions of terms

    def table(self, kind: str, name: str, rows: Iterable[str]) -> str:
        return table(kind, f"{self.name}_{name}", [*rows])

    def lines(self, found: Iterable[Statement], indent: int) -> str:
        return "\n".join(rendered(statements(found), indent))

    # -- functions of terms -------------------------------------------------------------------

    def functions(self, found: Iterable[Terms]) -> str:
        """Returns the C functions of terms, those that are not written yet."""
        text = ""
        for terms in found:
            if terms.name not in self._written:
                text += self._function(terms)
            self._written.add(terms.name)
        return text

    def _function(self, terms: Terms) -> str:
        name, block = f"{self.name}_{terms.name}", terms.block
        head: list[Node] = ["ptrdiff_t k;", *["pk_bits far = 0;"] * block.trig]
        for row in block.windows:
            pointer = self.readers.pointer(row, block.over)
            if f"{row.pointer}_room" in pointer:
                head.append(f"pk_real {row.pointer}_room[PK_BLOCK + {row.high - row.low}];")
            head.append(f"const pk_real *const {row.pointer} = {pointer};")
        inner = [*statements(block.statements, "pass", "far")]
        inner, constants = self._hoisted(inner)
        running = "j" if block.pairs else "m"
        if block.pairs:
            head.insert(0, "const ptrdiff_t m = row;")
        if running in block.words:
            inner.insert(0, f"const ptrdiff_t {running} = from + k;")
        head += [*constants, *statements(block.once)]
        body = [*head, "", *["PK_LANE_LOOP"] * (not terms.sequence)]
        body.append(Loop("k = 0; k < n; k++", [Scope(inner)]))
        if block.trig:
            made = Function(f"PK_TERM_PASS({name})", [*declared(self.name, body), "return far;"])
            return f"{made.text}PK_TERM_OF_PASSES({name})\n\n"
        return Function(f"PK_TERM({name})", declared(self.name, body)).text + "\n"

    def _hoisted(self, body: list[Node]) -> tuple[list[Node], list[Node]]:
        """Returns the body of a loop with local constants in place of parameters, and these.
        Compilers cannot know that the values which a term stores are not parameters."""
        words, names = set(re.findall(r"\w+", "\n".join(rendered(body)))), {}

        def local(match: re.Match) -> str:
            place, number, field = match[0], match[1], match[2]
            if field and field not in self.readers.places.scalar_fields:
                return place
            name = f"p_{field or 'c' + number}"
            while name in words:
                name += "_"
            return names.setdefault(place, name)

        lines = [_CONSTANT.sub(local, x) if isinstance(x, str) else x for x in body]
        return lines, [f"const pk_real {name} = {place};" for place, name in names.items()]

    # -- tables -------------------------------------------------------------------------------

    def terms_table(self, name: str, found: list[Terms]) -> str:
        """Returns the C functions of terms, and their table NAME_terms."""
        rows = [self._row(terms) for terms in found]
        return self.functions(found) + self.table("struct pk_terms", name, rows)

    def _row(self, terms: Terms) -> str:
        first = last = 0
        ends = list(terms.over) or [Affine(), Affine()]
        if terms.is_pairs:
            first, last = ends[2].factor(ROW), ends[3].factor(ROW)
            ends[2:] = [end.without(ROW) for end in ends[2:]]
        counts = len(terms.nodes), self.numbers.range(*ends), int(terms.is_pairs), first, last
        return f"{{{self.name}_{terms.name}, {', '.join(map(str, counts))}}}"

    # -- matrices -----------------------------------------------------------------------------

    def matrix(self, of: Kernel, unknowns: dict, end: str = "", terms: bool = True) -> str:
        """Returns the C functions and tables of a matrix, with the struct pk_matrix NAME_of.
        `unknowns` maps names of cells to numbers in a layout. Without `terms`, the functions of
        terms are left out, since the same matrix has them in another layout."""
        found, stem = of.terms, f"{self.name}_{of.name}"
        text = self.terms_table(f"{of.name}_terms", found) if terms else ""
        rows = [
            f"{{{found.index(x.terms)}, {x.value}, {x.sign}, {x.output}, "
            f"{self._cell(x.to[0], unknowns)}, {self._cell(x.to[1], unknowns)}}}"
            for terms in found
            for x in of.goals_of(terms)
        ]
        text += table("struct pk_entry", f"{stem}_{end}entries", rows)
        members = [
            f"{stem}_terms" if found else "NULL",
            f"{stem}_{end}entries" if rows else "NULL",
            *map(str, (len(found), len(rows), of.most, self._chunk(of))),
        ]
        return f"{text}static const struct pk_matrix {stem}_{end}of = {{\n{filled(members)}}};\n\n"

    def _chunk(self, of: Kernel) -> int:
        return min(self.block, members_in(of.most))

    def room_of_matrix(self, of: Kernel) -> int:
        return of.most * self._chunk(of)

    def _cell(self, cell: Cell, unknowns: dict) -> str:
        name, at = cell
        at = at if at is not None else Affine()
        shift, extra = self.numbers.shift(at.without(ROW))
        return f"{{{unknowns[name]}, {at.factor(ROW)}, {shift}, {extra}}}"
