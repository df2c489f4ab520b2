"""`conserve` where accelerations are not written out, and of families."""

from fractions import Fraction
from itertools import islice

import pytest
from claims import claims, outcomes

from conftest import case
from pkgen.compiler import check_model, stages
from pkgen.graph.graph import ONE, Graph, Kind, Symbol
from pkgen.graph.residues import Residues
from pkgen.middle.analyze.along import combination
from pkgen.source import ModelError, Source


def linked(count: int) -> str:
    """The angles of so many links, one at the end of the other, and the places of their ends."""
    n = range(1, count + 1)
    lines = [f"model m\ncoord {', '.join(f'a{i}' for i in n)}"]
    for of, x in (("x", "+ sin"), ("y", "- cos")):
        lines += [f"let {of}{i} = {f'{of}{i - 1}' if i > 1 else 0} {x}(a{i})" for i in n]
    return "\n".join(lines) + "\n"


def test_momenta_and_the_energy_need_no_acceleration():
    """Of six links, whose accelerations no normal form is found of."""
    n, text = range(1, 7), linked(6)
    text += "".join(f"kinetic (x{i}'^2 + y{i}'^2)/2\n" for i in n)
    total = " + ".join(f"p_a{i}" for i in n)
    assert (
        outcomes(text + f"conserve P = {total}\nconserve h = energy^2 + t - t\n") == ["proved"] * 2
    )
    found = claims(text + f"potential y6\nconserve P = {total}\nconserve h = energy*({total})^0\n")
    assert [claim.outcome for claim in found] == ["refuted", "proved"]


def test_large_systems_without_written_accelerations(monkeypatch):
    """The angular momentum of five links, by Cartesian lets: M x = w has the numbers x = 1."""
    monkeypatch.setattr("pkgen.middle.analyze.along.solve", lambda *_: None)
    n, text = range(1, 6), linked(5)
    text += "".join(f"kinetic (x{i}'^2 + y{i}'^2)/2\n" for i in n)
    turned = " + ".join(f"x{i}*y{i}' - y{i}*x{i}'" for i in n)
    text += f"conserve J = {turned}\nconserve W = {turned} + x5*y5'\nconserve S = ({turned})^2\n"
    made = stages(Source("x.lag", text), {}, frozenset({"conserve"}))
    *_, structure = islice(made, 4)
    first, second, third = structure.claims
    assert (first.outcome, second.outcome, third.outcome) == ("proved", "refuted", "not proved")
    assert float(third.says.split("below ")[1].split()[0]) < 1e-50


def test_a_combination_modulo_a_prime_is_only_a_guess():
    g = Graph()
    x, y = (g.symbol(Symbol(Kind.COORDINATE, i)) for i in range(2))
    rows = [[g.add(x, ONE), y], [y, g.number(2)]]
    wanted = [
        g.add(g.add(x, ONE), g.multiply(g.number(Fraction(-3, 2)), y)),
        g.subtract(y, g.number(3)),
    ]
    assert combination(g, rows, wanted) == [1, Fraction(-3, 2)]
    # x less its own residue is 0 in that world alone.
    wanted[0] = g.add(wanted[0], g.subtract(x, g.number(Residues(g)(x))))
    assert combination(g, rows, wanted) is None


def test_too_large_is_not_proved_and_does_not_hang():
    """The energy of five links by other angles: true, and beyond the work that is allowed."""
    n = range(1, 6)
    energies = "".join(f"kinetic (x{i}'^2 + y{i}'^2)/2\npotential y{i}\n" for i in n)
    text = linked(5) + energies
    total = " + ".join(f"(x{i}'^2 + y{i}'^2)/2 + 1 - 2*cos(a{i}/2)^2*{6 - i}" for i in n)
    (found,) = claims(f"{text}conserve c = {total}\n")
    assert found.outcome == "not proved" and "at 72 states" in found.says
    assert float(found.says.split("below ")[1].split()[0]) < 1e-50


CHAIN = case("proofs_large_chain")


def test_families_kept_as_loops():
    (claim,) = claims(CHAIN)
    assert claim.outcome == "proved" and claim.says.endswith("with N = 9")
    assert check_model(Source("x.lag", CHAIN))[1] == ()
    wrong = CHAIN.replace("m[i]*q[i]'", "q[i]'").replace(
        "kinetic sum(q[i]'", "kinetic sum(m[i]*q[i]'"
    )
    assert outcomes(wrong) == outcomes(wrong, N=400) == ["refuted"]


def test_a_claim_is_proved_for_every_length():
    (claim,) = claims(CHAIN, {"N": 1000})
    assert claim.outcome == "proved" and "with every length" in claim.says
    assert check_model(Source("x.lag", CHAIN), sizes={"N": 1000})[1] == ()
    (found,) = claims(CHAIN.replace("m[i]*q[i]'", "q[i]'^2/m[i]"), {"N": 1000})
    assert (found.outcome, "more than 500" in found.says) == ("not proved", True)
    far = CHAIN.replace("i = 1..N)\n", "i = 1..N) + 0*q[7]\n")
    assert [c.outcome for c in claims(far, {"N": 1000})] == ["proved"]


@pytest.mark.parametrize("size", [50, 1000])
@pytest.mark.parametrize(
    "more",
    [
        "dissipation sum(step(i - 40.5)*q[i]'^2, i = 1..N)",
        "potential sum(max(0, i - 5)*sin(t)*q[i]^2, i = 1..N)",
        "potential (N - 9)*(N - 10)*q[1]^2",
        "force q[N] = -0.1*q[N]'*(N - 9)",
    ],
)
def test_few_members_prove_nothing_of_many(more, size):
    """Each term vanishes, or nearly so, with few members."""
    assert outcomes(f"{CHAIN}{more}\n", N=size) != ["proved"]
    energy = "sum(m[i]*q[i]'^2/2, i = 1..N) + sum((q[i+1] - q[i])^2/2, i = 0..N)"
    text = CHAIN.replace(" + (q[i+1] - q[i])^4/4", "").replace(
        "conserve P = sum(m[i]*q[i]', i = 1..N)", f"conserve E = {energy}"
    )
    assert outcomes(text, N=size) == ["proved"]
    assert outcomes(f"{text}{more}\n", N=size) != ["proved"]


def test_a_sum_over_all_of_few_members():
    text = CHAIN.replace("sum(m[i]*q[i]', i = 1..N)", "sum(m[i]*q[i]', i = 1..5)")
    found = [outcomes(text, N=n) for n in (5, 50, 1000)]
    assert found == [["proved"], ["refuted"], ["not proved"]]


BODIES = """model bodies
size N = 1000
coord x[1..N], y[1..N]
kinetic sum((x[i]'^2 + y[i]'^2)/2, i = 1..N)
potential sum(-1/sqrt((x[i] - x[j])^2 + (y[i] - y[j])^2), i = 1..N, j = i+1..N)
start x[i = 1..N] = i
"""
RING = """model ring
size N = 1000
coord q[1..N]
periodic q
kinetic sum(q[i]'^2/2, i = 1..N)
potential sum(exp(q[i] - q[i+1]), i = 1..N)
"""
FIXED = RING.replace("periodic q", "fixed q[0] = 0, q[N+1] = 0.3").replace("i = 1..N)", "i = 0..N)")
FIXED = FIXED.replace("^2/2, i = 0..N", "^2/2, i = 1..N")
MEAN = """model mean
size N = 1000
param w[i = 1..N] = 1 + i/N in (0, inf)
coord q[1..N]
kinetic sum(w[i]*q[i]'^2/2, i = 1..N)
potential -sum(w[i]*cos(q[i]), i = 1..N)^2 - sum(w[i]*sin(q[i]), i = 1..N)^2
"""
TODA = "sum(q[i]'^3/3 + q[i]'*(exp(q[i] - q[i+1]) + exp(q[i-1] - q[i])), i = 1..N)"
OF_EVERY_LENGTH = {
    "the momentum of bodies": (BODIES, "sum(x[i]', i = 1..N)", True),
    "their angular momentum": (BODIES, "sum(x[i]*y[i]' - y[i]*x[i]', i = 1..N)", True),
    "its square": (BODIES, "sum(x[i]*y[i]' - y[i]*x[i]', i = 1..N)^2", True),
    "not the sum of areas": (BODIES, "sum(x[i]*y[i]' + y[i]*x[i]', i = 1..N)", False),
    "the centre": (BODIES, "sum(x[i], i = 1..N) - t*sum(x[i]', i = 1..N)", True),
    "Toda's third integral": (RING, TODA, True),
    "not another": (RING, TODA.replace("/3", "/2"), False),
    "not where ends are held": (FIXED, TODA, False),
    "the momentum of a ring": (RING, "sum(q[i]', i = 1..N)", True),
    "not of a chain": (FIXED, "sum(q[i]', i = 1..N)", False),
    "the energy of a chain": (
        FIXED, "sum(q[i]'^2/2, i = 1..N) + sum(exp(q[i] - q[i+1]), i = 0..N)", True),
    "the momentum in a mean field": (MEAN, "sum(w[i]*q[i]', i = 1..N)", True),
    "not without weights": (MEAN, "sum(q[i]', i = 1..N)", False),
}  # fmt: skip


@pytest.mark.parametrize("kind", OF_EVERY_LENGTH)
def test_constants_of_every_length(kind):
    text, claim, holds = OF_EVERY_LENGTH[kind]
    found = outcomes(f"{text}conserve A = {claim}\n")
    assert found == ["proved" if holds else "not proved"]
    assert outcomes(f"{text}conserve A = {claim}\n", N=5) == ["proved" if holds else "refuted"]


HEAD = "model m\nsize N = 600\ncoord {}\n"
FREE = "kinetic sum(q[i]'^2/2, i = 1..N)\n"
PLANE = """let P[i = 1..N] = [x[i] - x[i-1], y[i] - y[i-1], 0]
kinetic sum((x[i]'^2 + y[i]'^2)/2, i = 1..N)
force a[i = 1..1] at P[i] = [1, 0, 0]
conserve A = sum(x[i]', i = 1..N)
"""
# Each was proved by a step that is valid only inside a family.
NOT_CONSTANT = {
    "a weight on a ring that is not periodic": HEAD.format("q[1..N]")
    + "periodic q\nkinetic sum(i*q[i]'^2/2, i = 1..N)\n"
    + "potential sum(exp(q[i] - q[i+1]), i = 1..N)\nconserve A = sum(i*q[i]', i = 0..N-1)\n",
    "a family of masses on a ring": HEAD.format("q[1..N]")
    + "param w[i = 0..N] = 1 + 0.1*i in (0, inf)\nperiodic q\n"
    + "kinetic sum(w[i]*q[i]'^2/2, i = 1..N)\npotential sum(exp(q[i] - q[i+1]), i = 1..N)\n"
    + "conserve A = sum(w[i]*q[i]', i = 0..N-1)\n",
    "two families with other ends": HEAD.format("q[1..N], r[1..N]")
    + "free q[N+1]\nfixed r[N+1] = 0\nkinetic sum((q[i]'^2 + r[i]'^2)/2, i = 1..N)\n"
    + "potential sum(q[i+1]^2/2, i = 0..N) + sum(r[i]^2/2, i = 1..N)\n"
    + "conserve A = sum(r[i]*q[i]' - q[i]*r[i]', i = 1..N)\n",
    "a ring beside a chain": HEAD.format("q[1..N], r[1..N]")
    + "periodic q\nfixed r[N+1] = 0\nkinetic sum((q[i]'^2 + r[i]'^2)/2, i = 1..N)\n"
    + "potential sum(q[i+1]^2/2, i = 1..N) + sum(r[i]^2/2, i = 2..N)\n"
    + "conserve A = sum(r[i]*q[i]' - q[i]*r[i]', i = 1..N)\n",
    "a free end before a fixed one": HEAD.format("q[1..N]")
    + "free q[N+1]\nfixed q[N+2] = 0\n" + FREE
    + "potential sum((q[i+2] - q[i])^2/2, i = 1..N)\nconserve A = sum(q[i]', i = 1..N)\n",
    "empty ranges": HEAD.format("q[1..N]").replace("coord", "size K = 4\ncoord") + FREE
    + "conserve A = sum(q[i], i = 3..K-1) + sum(q[i], i = K..2)\n",
    "a state that is held": HEAD.format("q[1..N]")
    + "state u[1..N]\nfixed u[0] = 1\nfree u[N+1]\n" + FREE
    + "rate u[i = 1..N] = u[i-1] - 2*u[i] + u[i+1]\n"
    + "conserve A = sum(u[i] + q[i]', i = 1..N)\n",
    "a force at a point of one member": HEAD.format("x[1..N], y[1..N]")
    + "fixed x[0] = 0, y[0] = 0\n" + PLANE,
    "an end that moves": HEAD.format("q[1..N]") + "fixed q[0] = t, q[N+1] = 0\n" + FREE
    + "conserve A = sum((q[i+1] - q[i])^2, i = 0..N) - sum((q[i+1] - q[i])^2, i = 1..N-1)"
    + " - q[1]^2 + 2*q[1]*t - q[N]^2\n",
}  # fmt: skip


@pytest.mark.parametrize("kind", NOT_CONSTANT)
def test_no_step_of_a_proof_goes_beyond_an_end(kind):
    assert outcomes(NOT_CONSTANT[kind]) == ["not proved"]
    assert outcomes(NOT_CONSTANT[kind], N=5) == ["refuted"]


def test_expressions_deeper_than_the_stack_have_a_place():
    product = "*".join("R" * 400)
    text = f"model m\nrotation R\nkinetic dot(omega(R), omega(R))\npotential ({product}*[1,0,0]).x"
    with pytest.raises(ModelError) as found:
        check_model(Source("m.lag", text))
    (finding,) = found.value.diagnostics
    assert "too deep" in finding.message and finding.span.start > 40


def test_a_step_of_the_index_alone_is_no_kink():
    stiffer = CHAIN.replace("conserve P", "potential sum(step(i - 40.5)*q[i]^2, i = 1..N)\n#")
    assert facts(stiffer).smooth and facts(stiffer).conservative
    assert not facts(stiffer.replace("i - 40.5", "q[i]")).smooth


def facts(text):
    return next(islice(stages(Source("m.lag", text), {"N": 50}), 3, None))
