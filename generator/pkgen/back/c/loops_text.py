"""The C text of kernels of models with families: functions of terms and tables for members.h."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator

from ...graph.affine import ROW, Affine
from ...middle.loops.indexed_ir import Cell, Group
from ...middle.loops.loops import LoopEquations
from .ctext import fold_call
from .kernel_code import statements
from .loops_kernels import (
    BLOCK,
    Goal,
    Kernel,
    Terms,
    Vector,
    beyond,
    chunk_of,
    members_in,
    moves,
    reach,
)
from .loops_numbers import Numbers
from .program import Statement
from .tree import Declare, Function, Node, rendered


def filled(rows: Iterable[str], indent: int = 4) -> str:
    """Returns rows of a table, as many in a line as fit."""
    text = ", ".join(rows).replace("{ ", "{")
    return textwrap.fill(text, 98, initial_indent=" " * indent, subsequent_indent=" " * indent)


def table(kind: str, name: str, rows: list[str]) -> str:
    return f"static const {kind} {name}[{len(rows)}] = {{\n{filled(rows)}}};\n" if rows else ""


class KernelText:
    """Writes the kernels of one model."""

    def __init__(self, name: str, e: LoopEquations, numbers: Numbers):
        self.name, self.e, self.numbers = name, e, numbers
        self._written: set[str] = set()  # the functions of terms

    def table(self, kind: str, name: str, rows: Iterable[str]) -> str:
        return table(kind, f"{self.name}_{name}", [*rows])

    def lines(self, found: Iterable[Statement], indent: int) -> str:
        return "\n".join(rendered(statements(found), indent))

    # -- functions of terms -------------------------------------------------------------------

    def term(self, terms: Terms) -> str:
        name = f"{self.name}_{terms.name}"
        block, body = terms.block, []
        words = block.words
        if "p" in words:
            of = f"struct {self.name}_params"
            body.append(Declare(f"const {of} *const", "p", f"(const {of} *)x->params"))
        for word, kind in (("t", "const pk_real"), ("u", "const pk_real *const")):
            if word in words:
                body.append(Declare(kind, word, f"x->{word}"))
        if block.trig:
            body.append(Declare("pk_bits", "far", "0"))
        body += [*([""] if body else []), *statements(block.statements, "pass", "far")]
        body.append(f"return {'far' if block.trig else 0};")
        kind = "PAIRS" if terms.is_pairs else "SEQUENCE" if terms.sequence else "TERMS"
        return f"{Function(f'PK_TERM({name})', body).text}PK_{kind}({name})\n\n"

    def terms_table(self, name: str, found: list[Terms]) -> str:
        """Returns the C functions of terms, and their table NAME_terms."""
        if not found:
            return ""
        text, rows = "", []
        for terms in found:
            own = f"{self.name}_{terms.name}"
            slots = [self.numbers.slot(slot) for slot in terms.slots]
            if terms.name not in self._written:
                text += self.term(terms) + table("struct pk_slot", f"{own}_reads", slots)
            self._written.add(terms.name)
            rows.append(self._row(terms, f"{own}_reads" if slots else "NULL"))
        return f"{text}{table('struct pk_terms', f'{self.name}_{name}', rows)}\n"

    def _row(self, terms: Terms, reads: str) -> str:
        first = last = 0
        ends = list(terms.over) or [Affine(), Affine()]
        if terms.is_pairs:
            first, last = ends[2].factor(ROW), ends[3].factor(ROW)
            ends[2:] = [end.without(ROW) for end in ends[2:]]
        counts = len(terms.slots), len(terms.nodes), self.numbers.range(*ends)
        numbers = ", ".join(map(str, (*counts, int(terms.is_pairs), first, last)))
        return f"{{{self.name}_{terms.name}, {reads}, {numbers}}}"

    # -- vectors ------------------------------------------------------------------------------

    def vector(self, of: Vector) -> str:
        """Returns the C functions and tables of a vector, with the struct pk_vector NAME_of."""
        kinds = [of.of(kind) for kind in (2, 0, 4)]
        names = [f"{of.name}_{end}" for end in ("terms", "singles", "pairs")]
        text = "".join(self.terms_table(n, k) for n, k in zip(names, kinds, strict=True))
        text += "".join(self.rows(of, g) for g in of.families)
        sets = [self._set(of, g) for g in of.families]
        stem = f"{self.name}_{of.name}"
        text += table("struct pk_row_set", f"{stem}_sets", sets)
        scalars = [str(self.numbers.families[g.name, self._kind(g)]) for g in of.scalars]
        text += table("int", f"{stem}_scalars", scalars)
        counts, pointers = [], []
        for found, end in zip(kinds, ("terms", "singles", "pairs"), strict=True):
            goals = [goal for terms in found for goal in of.goals if goal.terms is terms]
            if end == "terms":
                goals = [goal for goal in goals if not moves(goal.to[0])]
            rows = [self._goal(goal, found) for goal in goals]
            text += table("struct pk_goal", f"{stem}_{end}_to", rows)
            counts.append(len(rows))
            pointers.append(f"{stem}_{end}_to" if rows else "NULL")
        low, high = reach(of)
        values = sum(len(terms.nodes) for terms in kinds[0])
        members = [
            *(f"{self.name}_{n}" if k else "NULL" for n, k in zip(names, kinds, strict=True)),
            *(str(len(k)) for k in kinds),
            *map(str, (values, len(sets), len(scalars))),
            f"{{{', '.join(map(str, counts))}}}",
            f"{stem}_sets" if sets else "NULL",
            f"{stem}_scalars" if scalars else "NULL",
            f"{{{', '.join(pointers)}}}",
            f"PK_{of.finish}",
            *map(str, (of.outputs, chunk_of(of), low, high, self.width(of))),
        ]
        return f"{text}static const struct pk_vector {stem}_of = {{\n{filled(members)}}};\n\n"

    def width(self, of: Vector) -> int:
        """Returns the length of a row of the buffer: members of a chunk and those before them."""
        low, high = reach(of)
        return chunk_of(of) + high - low

    def room(self, of: Vector) -> int:
        """Returns the length of the buffer of a vector's terms."""
        values = sum(len(terms.nodes) for terms in of.of(2))
        pairs = max((len(terms.nodes) for terms in of.of(4)), default=0)
        return max(1, values * self.width(of), pairs * BLOCK)

    def _goal(self, goal: Goal, found: list[Terms]) -> str:
        numbers = found.index(goal.terms), goal.value, goal.sign, goal.output
        return f"{{{', '.join(map(str, numbers))}, {self.numbers.cell(goal.to[0])}}}"

    def _set(self, of: Vector, g: Group) -> str:
        below, above = beyond(g, self.e)
        stem, raw = f"{self.name}_{of.name}_{self._id(g)}", "_raw" * (of.finish != "STORE")
        family = self.numbers.families[g.name, self._kind(g)]
        kick = f"{stem}_kick" if of.kicks else "NULL"
        return f"{{{family}, {below}, {above}, {stem}, {stem}{raw}, {kick}}}"

    def _kind(self, g: Group) -> str:
        return "" if (g.name, "") in self.numbers.families else "lambda"

    def _id(self, g: Group) -> str:
        return self.numbers.places.ids.get(g.name, f"row_{g.name}")

    def rows(self, of: Vector, g: Group) -> str:
        """Returns the C functions that add up the values of terms for members of a family."""
        first, place = 0, {}
        for terms in of.of(2):
            place[terms.name] = first
            first += len(terms.nodes)
        values = []
        for output in range(of.outputs):
            text = ""
            for goal in of.goals:
                cell = goal.to[0]
                if len(goal.terms.over) == 2 and goal.output == output and cell[0] == g.name:
                    row = (place[goal.terms.name] + goal.value) * self.width(of)
                    at = row - cell[1].constant
                    index = f"k{f' + {at}' if at > 0 else f' - {-at}' if at < 0 else ''}"
                    sign = (" - " if text else "-") if goal.sign < 0 else " + " * bool(text)
                    text += f"{sign}e[{index}]"
            values.append(text or "0")
        stem = f"static pk_bits {self.name}_{of.name}_{self._id(g)}"
        raw = self._rows(stem + "_raw" * (of.finish != "STORE"), enumerate(values))
        if of.kicks:
            a = values[0] if of.finish == "STORE" else f"({values[0]}) / ({values[1]})"
            body = [f"v[k] += kappa * ({a});", "q[k] += delta * v[k];"]
            raw += self._kick(f"static void {self.name}_{of.name}_{self._id(g)}_kick", body)
        if of.finish == "STORE":
            return raw
        mass = f"M = {values[-1]}"
        done = f"out[0][k] = ({values[0]}) / M;" if of.finish == "QUOTIENT" else "out[0][k] /= M;"
        body = [f"const pk_real {mass};", "bad |= !(M > 0);", done]
        return raw + self._loop(stem, body, True)

    def _rows(self, stem: str, values: Iterable[tuple[int, str]]) -> str:
        return self._loop(stem, [f"out[{k}][k] = {x};" for k, x in values], False)

    def _loop(self, stem: str, body: list[Node], bad: bool) -> str:
        args = "PK_PERHAPS const pk_real *e, ptrdiff_t n, pk_real *const *out"
        lines = [f"        {line}" for line in body]
        text = [
            fold_call(f"{stem}({args})"),
            "{",
            "    ptrdiff_t k;",
            *["    pk_bits bad = 0;"] * bad,
            "",
        ]
        text += ["    PK_LANE_LOOP", "    for (k = 0; k < n; k++) {", *_wrapped(lines), "    }"]
        return "\n".join([*text, f"    return {'bad' if bad else 0};", "}", "", ""])

    def _kick(self, stem: str, body: list[str]) -> str:
        lines = [
            f"{stem}(PK_PERHAPS const pk_real *e, ptrdiff_t n, pk_real kappa, pk_real delta,",
            "    pk_real *q, pk_real *v)",
            "{",
            "    ptrdiff_t k;",
            "",
            "    PK_LANE_LOOP",
            "    for (k = 0; k < n; k++) {",
            *_wrapped(f"        {line}" for line in body),
            "    }",
            "}",
        ]
        return "\n".join([*lines, "", ""])

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
            for x in of.goals
            if x.terms is terms
        ]
        text += table("struct pk_entry", f"{stem}_{end}entries", rows)
        members = [
            f"{stem}_terms" if found else "NULL",
            f"{stem}_{end}entries" if rows else "NULL",
            *map(str, (len(found), len(rows), of.most, self.chunk_of_matrix(of))),
        ]
        return f"{text}static const struct pk_matrix {stem}_{end}of = {{\n{filled(members)}}};\n\n"

    def chunk_of_matrix(self, of: Kernel) -> int:
        return members_in(of.most)

    def room_of_matrix(self, of: Kernel) -> int:
        return of.most * self.chunk_of_matrix(of)

    def _cell(self, cell: Cell, unknowns: dict) -> str:
        name, at = cell
        at = at if at is not None else Affine()
        shift, extra = self.numbers.shift(at.without(ROW))
        return f"{{{unknowns[name]}, {at.factor(ROW)}, {shift}, {extra}}}"


def _wrapped(lines: Iterable[str]) -> Iterator[str]:
    for line in lines:
        yield textwrap.fill(line, 98, subsequent_indent=" " * 12, break_long_words=False)
