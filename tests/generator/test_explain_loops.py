"""What `explain` shows of families kept as loops has the values of the unrolled equations."""

import math
import random
import re

import pytest
import sympy as sp
from loop_models import MODELS

from conftest import case
from pkgen.compiler import compile_model
from pkgen.explain.explain import explain, record
from pkgen.front.check import check
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.derive import derive
from pkgen.source import Source

N = 9
NAME = re.compile(r"([A-Za-z_]\w*)\b(?!\()(?:\[([^]]*)\])?('*)")
_IN = r"(?:[^()]|\([^()]*\))"  # in brackets up to two deep
SUM = re.compile(rf"sum\(((?:[^()]|\({_IN}*\))*), i = (\S+?)\.\.([^)\s]+)\)")


class Shown:
    """The texts of a report, evaluated at a random state."""

    def __init__(self, text: str) -> None:
        source = Source("model.lag", text)
        self.record = record(compile_model(source))
        model, _ = check.check_text(source, {"N": N})
        self.unrolled = e = derive.derive(model)
        seeded = random.Random(2385)
        self.values = {"t": 1.37, "N": N, "pi": math.pi}
        self.symbols = {Symbol(Kind.TIME): self.values["t"]}
        slots = [slot.quantity for slot in e.parameters]
        kinds = (Kind.PARAMETER, slots), (Kind.COORDINATE, e.coordinates)
        kinds += (Kind.RATE, e.rates), (Kind.INPUT, e.inputs)
        for kind, quantities in kinds:
            for k, quantity in enumerate(quantities):
                x = seeded.uniform(0.2, 0.9)
                self.values[quantity.name] = self.symbols[Symbol(kind, k)] = x
        self.turns: dict[str, int] = {}  # the first index of each periodic family
        for line in self.record["beyond"]:
            self._beyond(line)

    def _beyond(self, line: str) -> None:
        place, value, kind = re.fullmatch(r"(\S+) = (.*) \((\w+)\)", line).groups()
        family, at = re.fullmatch(r"(\w+)\[(.*)\]", place).groups()
        if kind == "periodic":
            names = [n for n in self.values if n.startswith(f"{family}[")]
            self.turns[family] = min(int(re.findall(r"\d+", n)[0]) for n in names)
            for name in names:
                k, mark = re.fullmatch(r"\w+\[(.*)\]('*)", name).groups()
                for turn in (N, -N):
                    self.values[f"{family}[{int(k) + turn}]{mark}"] = self.values[name]
        elif kind == "fixed":
            at, value, t = self.number(at, {}), sp.sympify(value), sp.Symbol("t")
            for order in range(3):
                exact = sp.diff(value, t, order).subs(
                    {n: self.values[n] for n in "Awt" if n in self.values}
                )
                self.values[f"{family}[{at}]{chr(39) * order}"] = float(exact)

    def member(self, name: str) -> str:
        """By the index that a periodic family gives it."""
        family, _, at = name.rstrip("]").partition("[")
        return (
            f"{family}[{(int(at) - self.turns[family]) % N + self.turns[family]}]"
            if family in self.turns
            else name
        )

    def number(self, text: str, index: dict[str, int]) -> float:
        def added(found: re.Match[str]) -> str:
            lo, hi = (self.number(end, index) for end in found.groups()[1:])
            return repr(sum(self.number(found[1], index | {"i": i}) for i in range(lo, hi + 1)))

        def looked_up(found: re.Match[str]) -> str:
            name, at, mark = found.groups()
            if at is not None:
                name = f"{name}[{self.number(at, index)}]"
            return repr((self.values | index)[name + mark])

        return eval(NAME.sub(looked_up, SUM.sub(added, text)).replace("^", "**"), vars(math).copy())

    def rows(self, lines: dict[str, str], index: dict[str, int]):
        """(left side with numbers, value) for every member that a line is about."""
        for key, right in lines.items():
            left, _, where = key.partition(" for i = ")
            lo, _, hi = where.partition("..")
            members = range(self.number(lo, {}), self.number(hi, {}) + 1) if where else [None]
            for i in members:
                at = index if i is None else index | {"i": i}
                name = re.sub(
                    r"\[([^][]*)\]", lambda m, at=at: f"[{self.number(m[1], at)}]", left[2:-1]
                )
                yield name, self.number(right, at)


# A periodic family whose bonds begin at its third member and wrap: some rows lie beyond its end.
PARTLY = case("partly")
# Of carried values the rows are those of L as it stands.
TEXTS = {name: text for name, (text, _) in MODELS.items() if name != "links"} | {"partly": PARTLY}


@pytest.mark.parametrize("name", TEXTS)
def test_rows_have_the_values_of_the_unrolled_equations(name: str) -> None:
    shown = Shown(TEXTS[name])
    e = shown.unrolled
    names = [q.name for q in e.coordinates]
    force = dict.fromkeys(names, 0.0)
    stated = set()
    for member, value in shown.rows(shown.record["force"], {}):
        assert member not in stated, "two lines about one member"
        stated.add(member)
        force[member] += value
    for pair in shown.record["pairs"]:
        lo, hi, first, last = re.fullmatch(
            r"i = (.*)\.\.(.*), j = (.*)\.\.(.*)", pair["range"]
        ).groups()
        for i in range(shown.number(lo, {}), shown.number(hi, {}) + 1):
            ends = [shown.number(end, {"i": i}) for end in (first, last)]
            for j in range(ends[0], ends[1] + 1):
                for member, value in shown.rows(pair["force"], {"i": i, "j": j}):
                    force[member] += value
    assert [force[n] for n in names] == pytest.approx(evaluate(e.graph, e.force, shown.symbols))
    assert any(force.values())

    observed = list(evaluate(e.graph, e.observed, shown.symbols))
    for key, text in shown.record["outputs"].items():
        lo, _, hi = key.partition(" for i = ")[2].partition("..")
        members = range(shown.number(lo, {}), shown.number(hi, {}) + 1) if lo else [0]
        values = [shown.number(text, {"i": i}) for i in members]
        assert values == pytest.approx([observed.pop(0) for _ in members]), key
    assert observed == []

    mass = {f"{a}, {b}": 0.0 for a in names for b in names}
    for entry, value in shown.rows(shown.record["mass"], {}):
        mass[", ".join(map(shown.member, entry.split(", ")))] += value
    for i, a in enumerate(names):
        row = evaluate(e.graph, e.mass[i], shown.symbols)
        for j, b in enumerate(names):
            once = mass[f"{a}, {b}"] + (mass[f"{b}, {a}"] if i != j else 0)
            assert once == pytest.approx(row[j]), f"M[{a}, {b}]"


def test_one_equation_stands_for_all_members_and_the_ends_are_apart() -> None:
    def said(name: str) -> list[str]:
        return explain(compile_model(Source("model.lag", MODELS[name][0]))).splitlines()

    fput = said("fput")
    assert "  M[q[i], q[i]] = 1   for i = 1..N" in fput
    assert sum(line.startswith("  f[") for line in fput) == 1
    assert "  where q[0] = 0 (fixed)" in fput
    ends = said("ends")
    assert "  f[q[1]] = -k*q[1] - q[1] + q[2] + (-q[1] + q[2])^3" in ends
    assert "  f[y[i]] = -y[i]   for i = 2..N-1" in ends
    assert "  where x[i+N] = x[i] (periodic)" in said("ring")
    paired = "\n".join(said("paired"))
    assert "f[y[i]] = -c*(-x[i]' + y[i]') - kk[i]*(-x[i] + y[i]) + i*push/N" in paired


def test_where_sizes_would_have_to_be_compared_parts_have_their_ranges() -> None:
    text = (
        "model two\nsize N = 30\nsize K = 20\ncoord q[1..N]\nkinetic sum(q[i]'^2/2, i = 1..N)\n"
        "potential sum(q[i]^2/2, i = 1..N) + sum(q[i]^4/4, i = 1..K)\n"
    )
    said = explain(compile_model(Source("model.lag", text)))
    assert "f[q[i]] = -q[i]   for i = 1..N\n  f[q[i]] = ... + -q[i]^3   for i = 1..K" in said


def test_an_index_has_a_letter_that_the_model_leaves_free():
    """sum(q[k]^2/2*k/i) of a parameter i is not sum(q[i]^2/2)."""
    text = (
        "model letters\nsize m = 40\nparam i = 2\ncoord q[1..m]\n"
        "kinetic sum(q[n]'^2/2, n = 1..m)\npotential sum(q[n]^2/2*n/i, n = 1..m)\n"
    )
    said = explain(compile_model(Source("model.lag", text)))
    assert "V = sum(k*q[k]^2/(2*i), k = 1..m)" in said
    assert "f[q[k]] = -k*q[k]/i   for k = 1..m" in said and "m degrees of freedom" in said


FELT = case("felt")


def test_sums_and_what_outputs_have_of_each_member_are_shown():
    said = explain(compile_model(Source("model.lag", FELT)))
    for line in (
        "  b[1..N] = i - sum(j, j = 1..N)/N",
        "  f[q[i]] = -2*b[i]*q[i] + u[i]' + sin(sum(q[i], i = 1..N)/N)/N   for i = 1..N",
        "  u[i]' = q[i] - u[i]   for i = 1..N",
        "Made along the members, for outputs alone",
        "  a[0] = 0",
        "  a[i] = a[i-1] + q[i]*sum(q[i], i = 1..N)/N   for i = 1..N",
        "  last = a[N]' + q[1]''",
    ):
        assert line in said.splitlines(), said
