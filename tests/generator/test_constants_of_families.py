"""Constants that are stated of long families: dA/dt at random states of the members."""

import random
from itertools import islice

import pytest

from conftest import seeds
from pkgen.back.facts import found
from pkgen.compiler import stages
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.analyze.along import Along
from pkgen.middle.derive import derive
from pkgen.source import ModelError, Source

KEPT = "q[i]'^2/2", "(q[i+1] - q[i])^2/2"
TERMS = (
    "dissipation sum({c}*q[i]'^2, i = 1..N)",
    "potential sum({c}*q[i]^2/9, i = 1..N)",
    "potential sum({c}*sin(t)*q[i], i = 1..N)",
    "force q[{at}] = -q[{at}]'/8",
    "force q[{at}] = sin(t)",
    "potential q[{at}]^4/8",
    "dissipation (N - {near})*(N - {far})*q[1]'^2",
)
INDEXED = (
    "step(i - {at} + 0.5)",
    "max(0, i - {near})",
    "(i - 1)*(i - 2)*(i - 3)/N^2",
    "(N - {near})/N",
    "1",
)


def model(seed: int) -> tuple[str, int, str]:
    draw = random.Random(seed)
    size = draw.randint(41, 200)
    numbers = {"at": draw.randint(1, size), "near": 5, "far": draw.choice((9, 10, size))}
    lo, hi, ends = draw.choice(
        ((1, "N-1", ""), (0, "N", "free q\n"), (0, "N", "fixed q[0] = 0, q[N+1] = 0\n"),
         (1, "N", "periodic q\n"))
    )  # fmt: skip
    text = f"model m\nsize N = {size}\ncoord q[1..N]\n{ends}"
    text += f"kinetic sum({KEPT[0]}, i = 1..N)\npotential sum({KEPT[1]}, i = {lo}..{hi})\n"
    for term in draw.sample(TERMS, draw.randint(0, 2)):
        text += term.format(c=draw.choice(INDEXED).format(**numbers), **numbers) + "\n"
    whole = f"sum({KEPT[0]}, i = 1..N) + sum({KEPT[1]}, i = {lo}..{hi})"
    claim = draw.choice((whole, "sum(q[i]', i = 1..N)", "sum(q[i]', i = 1..5)"))
    return text, size, f"conserve A = {claim}\n"


def slope(text: str, name: str, seed: int) -> float:
    """dA/dt over the size of its terms at a random state of the model written out."""
    e = derive.derive(next(islice(stages(Source("m.lag", text), {}), 1, 2))[1])
    along = Along(e, tuple((i,) for i in range(len(e.coordinates))))
    node = e.energy if name == "energy" else e.conserved[0]
    draw, values = random.Random(seed), {Symbol(Kind.TIME): 0.7}
    for kind in (Kind.COORDINATE, Kind.RATE):
        values |= {Symbol(kind, i): draw.gauss(0, 1) for i in range(len(e.coordinates))}
    for i, slot in enumerate(e.parameters):
        values[Symbol(Kind.PARAMETER, i)] = evaluate(e.graph, [slot.default], values)[0]
    rates = evaluate(along.graph, along.terms(node), values)
    g = e.graph
    power = evaluate(g, [g.multiply(g.symbol(Symbol(Kind.RATE, i)), f) for i, f in
                         enumerate(e.gradient)], values)  # fmt: skip
    return abs(sum(rates)) / (sum(map(abs, [*rates, *power])) or 1)


def judged(seed: int) -> tuple[int, bool]:
    """How many constants are stated, and whether the claim is proved."""
    text, _, claim = model(seed)
    made = list(islice(stages(Source("m.lag", text), {}, symmetric=True), 4))
    e, facts = made[2], made[3]
    names = [name for name, _ in found(e, facts)]
    assert set(names) <= {"energy"}, "no constant of a few members is stated of many"
    for name in names:
        assert slope(text, name, seed) < 1e-9, text
    try:
        list(islice(stages(Source("m.lag", text + claim), {}), 5))
    except ModelError:
        return len(names), False
    assert slope(text + claim, "A", seed) < 1e-9, text + claim
    return len(names), True


@pytest.mark.parametrize("seed", seeds([3, 5, 8], 2))
def test_what_is_stated_is_constant(seed):
    judged(seed)


def test_what_is_stated_is_constant_of_many():
    outcomes = [judged(seed) for seed in range(200)]
    assert sum(n for n, _ in outcomes) > 20 and sum(proved for _, proved in outcomes) > 20


MASSES = ("1", "i", "w[i]", "w[i-1]", "(2 + cos(q[i]))", "(1 + r[i]^2)")
# The ends of q, and a range of terms that reach from q[i] to q[i+1].
ENDS = (
    ("", "1..N-1"), ("free q[0]\n", "0..N-1"), ("free q[N+1]\n", "1..N"), ("free q\n", "0..N"),
    ("periodic q\n", "1..N"), ("periodic q\n", "0..N-1"), ("fixed q[0] = 0\n", "0..N-1"),
    ("fixed q[0] = 0, q[N+1] = 1\n", "0..N"), ("free q[N+1]\nfixed q[N+2] = 0\n", "1..N"),
    ("fixed q[0] = t\n", "0..N-1"), ("free q[0]\nfixed q[N+1] = 2\n", "0..N"),
)  # fmt: skip
BODIES = (
    "(q[i+1] - q[i])^2/2", "exp(q[i] - q[i+1])", "q[i+1]^2/2", "q[i]^2/2", "r[i]^2/2",
    "q[i]*r[i]", "cos(q[i] - r[i])", "i*q[i]", "(q[i+2] - q[i])^2/2", "w[i]*(q[i+1] - q[i])^4",
)  # fmt: skip
CLAIMED = (
    "{m}*q[i]'", "q[i]'", "{m}*q[i+1]'", "r[i]*q[i]' - q[i]*r[i]'", "{m}*q[i]' + r[i]'",
    "q[i+1] - q[i]", "(q[i+1] - q[i])^2", "{m}*q[i]'^2/2 + {v}", "{v}", "{m}*q[i]'^3",
    "{m}*q[i]'^2/2 + r[i]'^2/2 + {v}", "w[i-1]*q[i]'", "q[i]*q[i+1]'",
)  # fmt: skip
RANGES = ("1..N", "1..N", "1..N", "0..N-1", "2..N", "2..N+1", "1..1", "3..K-1", "K..2")


def weighted(dice: random.Random) -> str:
    """A model of two families, their ends and weights, and a claim."""
    mass, (ends, over), body = dice.choice(MASSES), dice.choice(ENDS), dice.choice(BODIES)
    ends += dice.choice(("", "", "periodic r\n"))
    text = "model m\nsize N = 600\nsize K = 4\nparam w[i = -1..N+3] = 5 + i in (0, inf)\n"
    text += f"coord q[1..N], r[1..N]\n{ends}"
    text += f"kinetic sum({mass}*q[i]'^2/2 + r[i]'^2/2, i = 1..N)\n"
    text += f"potential sum({body}, i = {over if 'i+' in body else '1..N'})\n"
    more = "sum(cos(q[i]), i = 1..N)^2", "sum((q[i] - q[j])^2, i = 1..N, j = i+1..N)"
    text += dice.choice(("", "", f"potential {dice.choice(more)}\n", "force q[1] = 1\n"))
    claim = dice.choice(CLAIMED).format(m=mass, v=body)
    if "i+" in claim and claim.endswith(body):  # An energy has each term on its own range.
        claims = [(claim.removesuffix(f" + {body}"), "1..N"), (body, over)]
    else:
        claims = [(claim, dice.choice(RANGES))]
    parts = [f"sum({claim}, i = {over})" for claim, over in claims]
    return f"{text}conserve A = {' + '.join(parts)}\n"


def test_what_is_proved_of_every_length_is_constant_of_few_members():
    proved = 0
    for seed in range(1000):
        text = weighted(random.Random(seed))
        try:
            *_, structure = islice(stages(Source("m.lag", text), {}), 4)
        except ModelError:
            continue
        if structure.claims[0].outcome == "proved":
            proved += 1
            few = text.replace("N = 600", "N = 7")
            assert slope(few, "A", seed) < 1e-9, text
    assert proved > 20
