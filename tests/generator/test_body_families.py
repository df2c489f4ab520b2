"""Families of bodies and joints against the same tree written one by one."""

import random
import re

import pytest

from conftest import case, seeds
from pkgen.front.check.body_families import TOO_MANY
from pkgen.front.check.check import check_text
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.derive.derive import derive
from pkgen.source import ModelError, Source

KINDS = ("revolute", "prismatic", "planar", "spherical", "free", "fixed")


def model_of(text: str, **sizes: int):
    return check_text(Source("tree.lag", text), sizes)[0]


class Trees:
    """The same tree twice: `family` has families, `single` a statement each body and joint, whose
    names are link_3 for link[3]."""

    def __init__(self, draw: random.Random):
        self.draw = draw
        self.family, self.single = ["model tree", "size N = 3"], ["model tree"]

    def number(self) -> str:
        return f"{self.draw.uniform(0.3, 1.5):.3f}"

    def of_i(self) -> str:
        """An expression of the member's number."""
        draw = self.draw
        return draw.choice((self.number(), f"({self.number()} + {self.number()}*i)", "sin(i)"))

    def vector(self) -> str:
        return f"[{self.of_i()}, {self.number()}, {self.of_i()}]"

    def both(self, text: str, members: range | None = None, indexed: bool = True) -> None:
        """A statement of each; RANGE stands for the range of a family."""
        if members is None:
            self.family.append(text)
            self.single.append(single(text, 0))
            return
        given = f"i = {members.start}..{members.stop - 1}"
        if not re.search(r"\bi\b", text):
            given = self.draw.choice((given, given[4:]))
        self.family.append(text.replace("RANGE", given))
        self.single += [single(text.replace("RANGE", "i"), k) for k in members]


def single(text: str, i: int) -> str:
    """For one i: indices computed, and made part of the name."""
    text = re.sub(r"\bi\b", str(i), text)
    text = re.sub(r"\[(\d+)-1\]", lambda m: f"[{int(m[1]) - 1}]", text)
    text = re.sub(r"coord way$", f"coord way_{i}", text)
    return re.sub(r"\b(link|leaf|j|k|way)\[(\d+)\]", r"\1_\2", text)


def trees(seed: int) -> tuple[str, str, int]:
    draw = random.Random(seed)
    t, n = Trees(draw), draw.randint(1, 4)
    t.family[1] = f"size N = {n}"
    all_ = range(1, n + 1)
    kind, leaf = draw.choice(KINDS), draw.choice(KINDS)
    axis = {"revolute", "prismatic", "planar"}
    planar = " [0, 2, 1]" if kind == "planar" else f" {t.vector()}"
    own = f"{kind}{planar if kind in axis else ''}"
    at = f" at {t.vector()}" * draw.randint(0, 1)
    turned = " turned rot([1, 2, 0], 0.3*i)*rot([0, 0, 1], 0.2)" * draw.randint(0, 1)
    named = (
        " coord way"
        if kind in ("revolute", "prismatic", "spherical") and draw.random() < 0.4
        else ""
    )
    first = re.sub(r"\bi\b", "1", own)
    lines = [
        ("gravity [0.3, -0.2, -9.81]", None),
        (
            f"body link[RANGE] mass {t.of_i()} + 2 inertia [1, 1.2 + i, 1.1 + i] at {t.vector()}",
            all_,
        ),
        (f"joint j[1]: ground to link[1] {first}{named}", all_[:1]),
    ]
    if n > 1:
        lines.append((f"joint j[RANGE]: link[i-1] to link[i] {own}{at}{turned}{named}", all_[1:]))
    some = all_[: draw.randint(0, n)]
    if some:
        vector = " [1, 0, 2]" if leaf in axis else ""
        lines.append((f"body leaf[RANGE] mass {t.number()} inertia [1, 2, 2, 0.1, 0.2, 0.3]", some))
        lines.append((f"joint k[RANGE]: link[i] to leaf[i] {leaf}{vector} at {t.vector()}", some))
    draw.shuffle(lines)
    for text, members in lines:
        t.both(text, members)
    if kind == leaf == "fixed" or (kind == "fixed" and not some):
        t.both("body last mass 1")
        t.both(f"joint x: link[{n}] to last prismatic [1, 2, 3]")
    for name, text in OUTPUTS.items():
        t.family.append(f"observe {name}[i = 1..{n}] = {text}")
        t.single += [f"observe {name}_{k} = {single(text, k)}" for k in all_]
    t.family.append("observe all = sum(link[i].mass*dot(link[i].com, [1, 2, 3]), i = 1..N)")
    terms = " + ".join(f"link_{k}.mass*dot(link_{k}.com, [1, 2, 3])" for k in all_)
    t.single.append(f"observe all = {terms}")
    return "\n".join(t.family) + "\n", "\n".join(t.single) + "\n", n


OUTPUTS = {
    "place": "link[i].point([1, 2, 3])",
    "turned": "link[i].R*[0.2, 0.3, 1] + link[i].omega",
    "back": "inverse(link[i].R)*link[i].origin",
    "angles": "tait_bryan(link[i].R)",
}


def plain(name: str) -> str:
    """As the other model has it: j_1_x for j_x[1]."""
    return re.sub(r"(\b[a-z]+)(_\w+)?\[(\d+)\]", r"\1_\3\2", name)


def values_of(model, found: dict[str, float]) -> dict:
    """By symbol, of names that both models have."""
    e = derive(model)
    symbols = {Symbol(Kind.TIME, 0): 0.0}
    for kind, quantities in (
        (Kind.COORDINATE, e.coordinates),
        (Kind.RATE, e.rates),
        (Kind.STATE, e.states),
    ):
        for k, q in enumerate(quantities):
            name = plain(q.name) + "'" * (kind is Kind.RATE and not q.name.endswith("'"))
            symbols[Symbol(kind, k)] = found.setdefault(name, random.Random(name).uniform(-1, 1))
    n = len(e.coordinates)
    names = [
        *(plain(q.name) + "''" for q in e.coordinates),
        "energy",
        *(plain(q.name) for q in e.observed_names),
    ]
    nodes = [*e.acceleration[:n], e.energy, *e.observed]
    return dict(zip(names, evaluate(e.graph, nodes, symbols), strict=True))


@pytest.mark.parametrize("seed", seeds(range(3), 57))
def test_a_family_is_the_tree_written_one_by_one(seed):
    family, one_by_one, _ = trees(seed)
    given: dict[str, float] = {}
    wanted = values_of(model_of(one_by_one), given)
    names = {*given}
    found = values_of(model_of(family), given)
    assert names == {*given} and found.keys() == wanted.keys(), family
    assert found == pytest.approx(wanted, rel=1e-10, abs=1e-10)
    assert max(map(abs, found.values())) > 0.1


TWIG = case("twig")


def test_members_on_the_command_line(pkgen, tmp_path):
    """--record takes a member's places, by its components; --size writes out as many."""
    model = tmp_path / "twig.lag"
    model.write_text(TWIG)
    run = ("run", model, "--until", "0.2", "--every", "0.1", "--size", "N=3")
    ran = pkgen(*run, "--record", "j[3],link[3].com,link[1].omega.y'")
    wanted = ["t", "j[3]", *(f"link[3].com.{axis}" for axis in "xyz"), "link[1].omega.y'"]
    assert ran.stdout.splitlines()[0].split(",") == wanted and "never used" not in ran.stderr
    assert [float(x) for x in ran.stdout.splitlines()[1].split(",")][1] == pytest.approx(0.3)
    ran = pkgen(*run, "--record", "link[9].com")
    assert ran.stderr.count("link[9].com is outside the family: there is link[1..3].com") == 1
    assert ran.returncode == 1 and not ran.stdout


def test_of_one_member_a_range_of_others_is_empty():
    text = case("body_families_chain")
    alone = re.sub("joint j.i.*\n|potential.*\n", "", text)
    given: dict[str, float] = {}
    wanted = values_of(model_of(alone, N=1), given)
    assert values_of(model_of(text, N=1), given) == wanted
    for wrong in (re.sub("joint j.1.*\n", "", text), text.replace("2..N]:", "3..N]:")):
        with pytest.raises(ModelError) as told:
            model_of(wrong, N=1)
        assert "an empty family" in told.value.diagnostics[0].message


def test_too_many_members_are_told_once():
    text = "model many\nsize N = 15000\n" + "".join(
        f"body {x}[1..N] mass 1\njoint j{x}[i = 1..N]: ground to {x}[i] revolute [0, 1, 0]\n"
        for x in "ab"
    )
    with pytest.raises(ModelError) as told:
        model_of(text)
    assert [d.message for d in told.value.diagnostics] == [TOO_MANY]
