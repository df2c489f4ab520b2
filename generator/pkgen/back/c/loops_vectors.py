"""The C text that adds up terms: to a value for each member of families, or to one number.

Rows are computed in chunks. A chunk's terms are written to the buffer e; then each row is a sum of
elements of e. Rows beyond a ring's end or a free end are added to the members that they stand for.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from ...graph.affine import OTHER, Affine, variable
from ...middle.loops.indexed_ir import Group
from ...middle.loops.loops import LoopEquations
from .loops_blocks import plus
from .loops_kernels import Goal, Terms, Vector, added, chunk_of, halo_of, reach, rows_beyond
from .loops_merge import moves
from .loops_places import M, Places
from .loops_readers import Ends, Readers, declared
from .tree import Function, If, Loop, Node, Scope, rendered

X = "const struct pk_members *x"


class VectorText:
    """The C text of one vector of a model."""

    def __init__(self, of: Vector, e: LoopEquations, places: Places, readers: Readers, block: int):
        self.of, self.places, self.name = of, places, f"{e.model.name}_{of.name}"
        self.model, self.index = e.model.name, places.index
        self.halo, self.low = halo_of(of), reach(of)[0]
        self.most, self.chunk, self.count = reach(of)[1], chunk_of(of, block), added(of, e)
        self.width = self.chunk + self.halo
        self.values = sum(len(terms.nodes) for terms in of.of(2))
        self.ends = {g.name: readers.ends(g) for g in of.families}
        self.beyond = {g.name: rows_beyond(of, g, e) for g in of.families}
        self.has_ends = self.count > 0
        self.scalars = [g.name for g in of.scalars]
        self.finished = of.outputs if of.finish == "STORE" else 1

    # -- pieces -------------------------------------------------------------------------------

    def _place(self, g: Group, at: str) -> str:
        """Returns the index in arrays of the member `at` of a family."""
        return self.index(self.places.first[g.name] + variable(at) - g.lo)

    def _rows(self, g: Group, width: int) -> list[str]:
        """Returns the row of each output before a division, as the sum of elements of e."""
        first, place = 0, {}
        for terms in self.of.of(2):
            place[terms.name] = first
            first += len(terms.nodes)
        values = []
        for output in range(self.of.outputs):
            text = ""
            for goal in self.of.goals:
                cell = goal.to[0]
                if len(goal.terms.over) == 2 and goal.output == output and cell[0] == g.name:
                    column = self.most - cell[1].constant
                    row = place[goal.terms.name] + goal.value
                    sign = (" - " if text else "-") if goal.sign < 0 else " + " * bool(text)
                    text += f"{sign}e[{plus('k', row * width + column)}]"
            values.append(text or "0")
        return values

    def _fills(self, first: str, n: str, e: str, width: int) -> Iterator[Node]:
        """Yields the calls that write the terms of n rows to e; `first` is the index m of the first
        column."""
        done = 0
        for terms in self.of.of(2):
            lo, hi = map(self.index, terms.over)
            to = f"{e} + {done * width}" if done else e
            own = f"{self.model}_{terms.name}, {len(terms.nodes)}, {lo}, {hi}"
            yield f"pk_fill(x, {own}, {first}, {n}, {to}, {width});"
            done += len(terms.nodes)

    def _clip(self, g: Group) -> tuple[str, str]:
        """Returns the range of k of a family's members in a chunk."""
        ends, (first, last) = self.ends[g.name], self.range
        low = "0" if first == ends.lo else f"pk_most(0, {ends.lo} - from)"
        high = "n" if last == ends.hi else f"pk_least(n, {ends.hi} + 1 - from)"
        return low, high

    @property
    def range(self) -> tuple[str, str]:
        """The least and the greatest row of all families; terms of scalars extend it."""
        lows = [self.ends[g.name].lo for g in self.of.families]
        highs = [self.ends[g.name].hi for g in self.of.families]
        for terms in dict.fromkeys(goal.terms.name for goal in self._to_scalars):
            over = next(x.over for x in self.of.of(2) if x.name == terms)
            lows.append(self.index(over[0] + self.most))
            highs.append(self.index(over[1] + self.low))
        return extreme(lows, "pk_least"), extreme(highs, "pk_most")

    @property
    def _to_scalars(self) -> list[Goal]:
        return [g for g in self.of.goals if len(g.terms.over) == 2 and not moves(g.to[0])]

    def _lane_loop(self, low: str, high: str, body: Sequence[str]) -> list[Node]:
        return ["PK_LANE_LOOP", Loop(f"k = {low}; k < {high}; k++", [Scope(body)])]

    # -- functions before the kernel ----------------------------------------------------------

    @property
    def functions(self) -> str:
        """Returns the functions NAME_ends, of what is added to rows one by one, and those by which
        steps kick and drift."""
        text = self._ends_function() if self.has_ends else ""
        return text + (self._kick() + self._drift() if self.of.kicks else "")

    def _ends_function(self) -> str:
        says = "Lists what is added to single rows of first .. end - 1, and adds up scalars."
        head = (
            f"static int {self.name}_ends({X}, ptrdiff_t first, ptrdiff_t end, "
            "struct pk_added *added, pk_real *scalars)"
        )
        body: list[Node] = ["const ptrdiff_t k = 0;", "int count = 0;", "", *self._singles()]
        for number, g in enumerate(self.of.families):
            body += self._beyond(number, g)
        unused = _unused(("x", "k", "first", "end", "added", "scalars"), body)
        body = [*declared(self.model, body), *unused, "return count;"]
        return Function(head, body, says).text + "\n"

    def _append(self, number: int, output: int, ends: Ends, at: str, value: str) -> str:
        home = ends.home(at) if ends.are_members else at
        there = f"added, count, {number}, {output}, {home}, {ends.lo}, first, end, {value}"
        return f"count = pk_append({there});"

    def _singles(self) -> Iterator[Node]:
        names = [g.name for g in self.of.families]
        for terms in self.of.of(0):
            count = len(terms.nodes)
            to = ", ".join(f"one + {k}" for k in range(count))
            body: list[Node] = [f"pk_real one[{count}], *const o[] = {{{to}}};", ""]
            body.append(f"{self.model}_{terms.name}(x, 0, 0, 1, o);")
            for goal in (goal for goal in self.of.goals if goal.terms is terms):
                (name, at), sign = goal.to[0], "-" if goal.sign < 0 else ""
                if name in self.scalars:
                    k = self.scalars.index(name) * self.of.outputs + goal.output
                    body.append(f"scalars[{k}] += {sign}one[{goal.value}];")
                else:
                    ends, value = self.ends[name], f"{sign}one[{goal.value}]"
                    own = names.index(name), goal.output, ends, self.index(at), value
                    body.append(self._append(*own))
            yield Scope(body)

    def _beyond(self, number: int, g: Group) -> Iterator[Node]:
        """Yields the rows beyond the ends of a family."""
        ends, width = self.ends[g.name], self.halo + 1
        below, above = self.beyond[g.name]
        rows = [self.index(g.lo - k) for k in range(1, below + 1)]
        rows += [self.index(g.hi + k) for k in range(1, above + 1)]
        if not self.values:
            return
        for row in rows:
            body: list[Node] = [
                f"pk_real e[{self.values * width}];",
                f"const ptrdiff_t i = {row}, home = {ends.home('i')};",
                "",
            ]
            inner: list[Node] = [*self._fills(plus("i", -self.most), str(width), "e", width)]
            inner += [
                f"count = pk_append(added, count, {number}, {output}, home, {ends.lo}, first, end, "
                f"{value});"
                for output, value in enumerate(self._rows(g, width))
                if value != "0"
            ]
            there = f"home >= {ends.lo} && home >= first && home < end"
            yield Scope([*body, If(there, [Scope(inner)])])

    def _kick(self) -> str:
        """Returns NAME_kick, which makes v += kappa a, q += delta v for the rows of a chunk."""
        body: list[Node] = ["ptrdiff_t k;", *self._added_to("from", "from + n"), ""]
        first = f"from{self._minus} + known"
        count = f"n + {self.halo} - known" if self.halo else "n - known"
        body += self._fills(first, count, "e + known", self.width)
        for number, g in enumerate(self.of.families):
            values, (low, high) = self._rows(g, self.width), self._clip(g)
            place = self._place(g, "from")
            q, v = f"q[{place} + k]", f"v[{place} + k]"
            quotient = self.of.finish == "QUOTIENT"
            a = f"({values[0]}) / ({values[1]})" if quotient else values[0]
            fused = self._lane_loop(low, high, [f"{v} += kappa * ({a});", f"{q} += delta * {v};"])
            if not (self.has_ends and quotient):
                body += fused
                body += self._kicked_ends(number, g) if self.has_ends else ()
                continue
            a = "r[k] / r[PK_BLOCK + k]"
            slow = [f"pk_real r[{self.of.outputs} * PK_BLOCK];", ""]
            slow += self._buffered(number, values, low, high, "PK_BLOCK")
            slow += self._lane_loop(low, high, [f"{v} += kappa * ({a});", f"{q} += delta * {v};"])
            body += [If("!n_added", [Scope(fused)]), If("n_added", [Scope(slow)])]
        args = "ptrdiff_t known, pk_real *e, pk_real kappa, pk_real delta, pk_real *q, pk_real *v"
        head = f"static void {self.name}_kick({X}, ptrdiff_t from, ptrdiff_t n, {args})"
        return (
            Function(head, [*declared(self.model, body), *_unused(("x", "known", "e"), body)]).text
            + "\n"
        )

    def _kicked_ends(self, number: int, g: Group) -> Iterator[Node]:
        """Yields the lines that kick single rows by what is added to their accelerations."""
        at = self._place(g, "added[k].i")
        kicks = [
            "const pk_real kick = kappa * added[k].value;",
            "",
            f"v[{at}] += kick;",
            f"q[{at}] += delta * kick;",
        ]
        own = If(f"added[k].family == {number}", [Scope(kicks)])
        yield Loop("k = 0; k < n_added; k++", [own])

    def _drift(self) -> str:
        body: list[Node] = ["ptrdiff_t k;", "", "(void)x;"]
        for g in self.of.families:
            place, (low, high) = self._place(g, "from"), self._clip(g)
            body += self._lane_loop(low, high, [f"q[{place} + k] += delta * v[{place} + k];"])
        args = "ptrdiff_t n, pk_real delta, pk_real *q, const pk_real *v"
        head = f"static void {self.name}_drift({X}, ptrdiff_t from, {args})"
        text = Function(head, declared(self.model, body)).text
        first, last = self.range
        numbers = self.chunk, self.halo, self.width, self.values
        kicks = f"{self.name}_kick, {self.name}_drift, {first}, {last} + 1"
        self.kicks = f"{{{kicks}, {', '.join(map(str, numbers))}}}"
        return text + "\n"

    @property
    def _minus(self) -> str:
        return plus("", -self.most).rstrip() if self.most else ""

    def _added_to(self, first: str, end: str, scalars: str = "NULL") -> list[Node]:
        if not self.has_ends:
            return []
        if not self.of.families:
            return [f"(void){self.name}_ends(x, 0, 0, NULL, {scalars});"]
        call = f"{self.name}_ends(x, {first}, {end}, added, {scalars})"
        return [
            f"struct pk_added added[{self.count}] = {{{{0, 0, 0, 0}}}};",
            f"const int n_added = {call};",
        ]

    def _buffered(
        self, number: int, values: Sequence[str], low: str, high: str, width: str
    ) -> list[Node]:
        """Returns the lines that write the rows of a family before a division to r."""
        stores = [
            f"r[{f'{k} * {width} + ' if k > 1 else f'{width} + ' if k else ''}k] = {value};"
            for k, value in enumerate(values)
        ]
        loop = self._lane_loop(low, high, stores)
        return [*loop, f"pk_add_to(added, n_added, {number}, from, n, r, {width});"]

    # -- the kernel ---------------------------------------------------------------------------

    def body(self, out: Sequence[str], bad: str = "") -> str:
        """Returns the C lines that compute the vector, in a function that has `x`; out[k] is the
        array of output k. A mass that is not positive sets the variable `bad`."""
        of, scalars = self.of, len(self.scalars) * self.of.outputs
        head: list[Node] = []
        if self.values:
            head.append(f"pk_real e[{self.values * self.width}];")
        if scalars:
            head.append(f"pk_real scalars[{scalars}] = {{0}};")
        if self._to_scalars:
            head.append(f"pk_real sums[{scalars}][8] = {{{{0}}}};")
        head += self._added_to("PTRDIFF_MIN", "PTRDIFF_MAX", "scalars" if scalars else "NULL")
        if self.is_direct:
            return "\n".join(rendered(self._direct(out)))
        loop = [*self._chunks(out, bad)]
        if loop:
            names = ["from", "n", *["k"] * bool(of.families), *["known = 0"] * bool(self.halo)]
            loop = [f"ptrdiff_t {', '.join(names)};", "", *loop]
        more: list[Node] = []
        if of.finish == "STORE" and self.has_ends:
            more += self._stored(out)
        for number, g in enumerate(of.scalars):
            more += self._scalar(number, g, out, bad)
        for terms in of.of(4):
            more += self._pairs(terms, out)
        body = [*head, *(loop if not more else [Scope(loop)] if loop else []), *more]
        return "\n".join(rendered([*body, *_unused(("x", *out), body)]))

    @property
    def is_direct(self) -> bool:
        """Whether each row is one value of one term, which writes the rows itself."""
        of, goals = self.of, self.of.goals
        cells = {(goal.to[0][0], goal.output) for goal in goals}
        return (
            of.finish == "STORE"
            and not (self.has_ends or of.scalars or of.of(4))
            and len(goals) == len(cells) > 0
            and len(goals) == len(of.families) * of.outputs
            and len(goals) == sum(len(terms.nodes) for terms in of.terms)
            and all(goal.sign > 0 and goal.to[0][1] == M for goal in goals)
            and all(self._is_whole(goal) for goal in goals)
        )

    def _is_whole(self, goal: Goal) -> bool:
        ends = self.ends[goal.to[0][0]]
        return tuple(map(self.index, goal.terms.over)) == (ends.lo, ends.hi)

    def _direct(self, out: Sequence[str]) -> Iterator[Node]:
        """Yields the loops in which terms write rows."""
        yield "ptrdiff_t from, n;"
        yield ""
        groups = {g.name: g for g in self.of.families}
        for terms in self.of.terms:
            goals = sorted((x for x in self.of.goals if x.terms is terms), key=lambda x: x.value)
            lo, hi = map(self.index, terms.over)
            to = [f"{out[x.output]} + {self._place(groups[x.to[0][0]], 'from')}" for x in goals]
            body = [
                f"pk_real *const o[] = {{{', '.join(to)}}};",
                "",
                f"n = pk_step(from, {lo}, {hi});",
                f"{self.model}_{terms.name}(x, 0, from, n, o);",
            ]
            yield Loop(f"from = {lo}; from <= {hi}; from += n", [Scope(body)])

    def _chunks(self, out: Sequence[str], bad: str) -> Iterator[Node]:
        if not self.of.families and not self._to_scalars:
            return
        first, last = self.range
        known = " + known" if self.halo else ""
        more = f"n + {self.halo} - known" if self.halo else "n"
        body: list[Node] = [f"n = pk_least({self.chunk}, {last} + 1 - from);"]
        body += self._fills(f"from{self._minus}{known}", more, f"e{known}", self.width)
        for number, g in enumerate(self.of.families):
            body += self._family(number, g, out, bad)
        for goal in self._to_scalars:
            row = 0
            for terms in self.of.of(2):
                if terms is goal.terms:
                    break
                row += len(terms.nodes)
            start = (row + goal.value) * self.width
            number = self.scalars.index(goal.to[0][0]) * self.of.outputs + goal.output
            row = f"e + {start}" if start else "e"
            body.append(f"pk_add_up({row}{known}, {more}, {goal.sign}, sums[{number}]);")
        if self.halo:
            body.append(f"pk_keep(e, {self.values}, {self.width}, n, {self.halo});")
            body.append(f"known = {self.halo};")
        yield Loop(f"from = {first}; from <= {last}; from += n", [Scope(body)])

    def _family(self, number: int, g: Group, out: Sequence[str], bad: str) -> Iterator[Node]:
        values, (low, high) = self._rows(g, self.width), self._clip(g)
        place = self._place(g, "from")
        where = f"[{place} + k]"
        if self.of.finish == "STORE":
            stores = [f"{out[k]}{where} = {value};" for k, value in enumerate(values)]
            yield from self._lane_loop(low, high, stores)
            return
        quotient = self.of.finish == "QUOTIENT"
        mass = values[1] if quotient else values[0]
        force = f"({values[0]})" if quotient else f"{out[0]}{where}"
        slow: list[Node] = []
        if self.has_ends:
            width = str(self.chunk)
            slow = [f"pk_real r[{self.of.outputs * self.chunk}];", ""]
            slow += self._buffered(number, values, low, high, width)
            mass = f"r[{width} + k]" if quotient else "r[k]"
            force = "r[k]" if quotient else force
        lines = [f"const pk_real M = {mass};", *[f"{bad} |= !(M > 0);"] * bool(bad)]
        lines.append(f"{out[0]}{where} = {force} / M;")
        loop = self._lane_loop(low, high, lines)
        yield from [Scope([*slow, *loop])] if slow else loop

    def _stored(self, out: Sequence[str]) -> Iterator[Node]:
        """Yields the lines that add to single rows."""
        for number, g in enumerate(self.of.families):
            arrays = ", ".join(out)
            place = self._place(g, "added[k].i")
            add = f"to[added[k].output][{place}] += added[k].value;"
            yield Scope(
                [
                    f"pk_real *const to[] = {{{arrays}}};",
                    "int k;",
                    "",
                    Loop("k = 0; k < n_added; k++", [If(f"added[k].family == {number}", [add])]),
                ]
            )

    def _scalar(self, number: int, g: Group, out: Sequence[str], bad: str) -> Iterator[Node]:
        first = number * self.of.outputs
        if self._to_scalars:
            for k in range(first, first + self.of.outputs):
                yield f"scalars[{k}] += pk_whole(sums[{k}]);"
        at = f"[{self.index(self.places.first[g.name])}]"
        if self.of.finish == "STORE":
            for k in range(self.of.outputs):
                yield f"{out[k]}{at} = scalars[{first + k}];"
            return
        quotient = self.of.finish == "QUOTIENT"
        mass = f"scalars[{first + quotient}]"
        if bad:
            yield f"{bad} |= !({mass} > 0);"
        yield f"{out[0]}{at} = {f'scalars[{first}]' if quotient else f'{out[0]}{at}'} / {mass};"

    def _pairs(self, terms: Terms, out: Sequence[str]) -> Iterator[Node]:
        goals = [goal for goal in self.of.goals if goal.terms is terms]
        lines: list[Node] = []
        for goal in goals:
            (name, at), sign = goal.to[0], "-" if goal.sign < 0 else "+"
            own = self.places.first[name]
            if at is not None and at.factor(OTHER):
                place = own + at.replaced({OTHER: variable("from")}) - self._lo(name)
                text = f"{out[goal.output]}[{self.index(place)} + k] {sign}= o[{goal.value}][k];"
                lines.append(Loop("k = 0; k < n; k++", [text]))
                continue
            place = own if at is None else own + at - self._lo(name)
            lines.append(
                Scope(
                    [
                        "pk_real eight[8] = {0};",
                        f"pk_add_up(o[{goal.value}], n, 1, eight);",
                        f"{out[goal.output]}[{self.index(place)}] {sign}= pk_whole(eight);",
                    ]
                )
            )
        yield Scope([*pair_loop(self.model, self.places, terms, lines)])

    def _lo(self, name: str) -> Affine:
        return next(g.lo for g in self.of.families if g.name == name)


def _unused(names: Iterable[str], body: Sequence[Node]) -> list[Node]:
    """Returns a statement for each name that the body does not use."""
    text = "\n".join(rendered(body))
    return [f"(void){x};" for x in names if not re.search(rf"\b{x}\b(?! =)", text)]


def extreme(found: Iterable[str], call: str) -> str:
    text, *more = dict.fromkeys(found)
    for other in more:
        text = f"{call}({text}, {other})"
    return text


def pair_loop(model: str, places: Places, terms: Terms, lines: Sequence[Node]) -> Iterator[Node]:
    """Yields the lines that evaluate terms of pairs, n at a time, and use them by `lines`: value k
    is o[k][0], o[k][1], ..."""
    lo, hi, first, last = map(places.index, terms.over)
    count = len(terms.nodes)
    to = ", ".join(f"pairs + {k} * PK_BLOCK" if k else "pairs" for k in range(count))
    yield f"pk_real pairs[{count} * PK_BLOCK], *const o[] = {{{to}}};"
    yield f"ptrdiff_t m, from, n{', k' if any(isinstance(x, Loop) for x in lines) else ''};"
    yield ""
    inner = [
        f"n = pk_least(PK_BLOCK, {last} + 1 - from);",
        f"{model}_{terms.name}(x, m, from, n, o);",
        *lines,
    ]
    yield Loop(
        f"m = {lo}; m <= {hi}; m++",
        [Loop(f"from = {first}; from <= {last}; from += n", [Scope(inner)])],
    )
