"""What is said to be constant of families whose members differ by their index, or by N."""

import random

import pytest

from conftest import ROOT, seeds
from pkgen.compiler import compile_model
from pkgen.middle.analyze.proofs import PROVED
from pkgen.source import ModelError, Source

HEAD = """\
model members
size N = {n}
coord q[1..N]
{ends}
kinetic sum(q[i]'^2/2, i = 1..N)
potential sum((q[i+1] - q[i])^2/2 + (q[i+1] - q[i])^4/8, i = 1..N-1)
start q[i = 1..N] = sin(i)
"""
# What a member has, as text of i and as a function of i and N.
WEIGHTS = {
    "1": lambda i, n, k: 1,
    "step(i - {k}.5)": lambda i, n, k: i > k,
    "step({k}.5 - i)": lambda i, n, k: i <= k,
    "max(0, i - {k})": lambda i, n, k: max(0, i - k),
    "(i - 1)*(i - 2)*(i - 3)*(i - 4)*(i - 5)": lambda i, n, k: i > 5,
    "(N - {k})": lambda i, n, k: n - k,
    "(N - 5)*(N - 6)*(N - 7)*(N - 8)": lambda i, n, k: (n - 5) * (n - 6) * (n - 7) * (n - 8),
}
# What a term does to the energy and to the momentum.
TERMS = {
    "potential sum({w}*q[i]^2/2, i = 1..N)": (True, False),
    "potential sum({w}*sin(t)*q[i]/9, i = 1..N)": (False, False),
    "potential sum({w}*cos(t)*(q[i+1] - q[i])^2/9, i = 1..N-1)": (False, True),
    "dissipation sum({w}*q[i]'^2/2, i = 1..N)": (False, False),
    "dissipation sum({w}*(q[i+1]' - q[i]')^2/2, i = 1..N-1)": (False, True),
}
MOMENTUM = "conserve P = sum(q[i]', i = 1..N)\n"
TOTAL = "conserve E = energy\n"


def drawn(seed: int) -> tuple[str, bool, bool]:
    """A model, and whether its energy and its momentum are constant."""
    draw = random.Random(seed)
    n = draw.choice([41, 50, 77, 200, 401, 2000])
    free = draw.random() < 0.8
    energy = momentum = True  # no spring leads beyond the ends
    text = HEAD.format(n=n, ends="free q" if free else "")
    for _ in range(draw.randint(0, 2)):
        weight, term = draw.choice([*WEIGHTS]), draw.choice([*TERMS])
        k = draw.choice([5, 6, 23, 40, n - 1, n, n + 3])
        last = n - ("i+1" in term)
        if any(WEIGHTS[weight](i, n, k) for i in range(1, last + 1)):
            energy, momentum = energy & TERMS[term][0], momentum & TERMS[term][1]
        text += term.format(w=weight.format(k=k)) + "\n"
    return text, energy, momentum


def proved(text: str) -> bool:
    try:
        made = compile_model(Source("members.lag", text), unroll=16)
    except ModelError as error:
        assert "not constant" in str(error.diagnostics) or "not proved" in str(error.diagnostics)
        return False
    return all(claim.outcome == PROVED for claim in made.structure.claims)


@pytest.mark.parametrize("seed", seeds(range(3), 117))
def test_what_is_said_to_be_constant_is(seed):
    text, energy, momentum = drawn(seed)
    made = compile_model(Source("members.lag", text), unroll=16, symmetric=True)
    found = made.structure.symmetries
    said = {x.name for x in found.invariants} if found else set()
    assert energy or "energy" not in said
    assert energy or not made.structure.conservative
    assert momentum or not any(name.startswith("p_q[1]") for name in said)
    assert energy or not proved(text + TOTAL)
    assert momentum or not proved(text + MOMENTUM)


@pytest.mark.parametrize("n", [50, 400, 100_000])
def test_what_is_constant_for_any_number_is_proved(n):
    text = HEAD.format(n=n, ends="free q") + MOMENTUM + TOTAL
    assert proved(text)
    more = "param m[i = 1..N] = 1 + i in (0, inf)\nkinetic sum(m[i]*q[i]'^2/2, i = 1..N)\n"
    assert proved(HEAD.format(n=n, ends="free q") + more + TOTAL)


@pytest.mark.parametrize("name", ["absorbing_layer_claim", "five_members_claim"])
def test_claims_of_some_members_are_refuted_with_all(name):
    text = (ROOT / "tests" / "cases" / f"{name}.lag").read_text()
    with pytest.raises(ModelError) as caught:
        compile_model(Source(name, text))
    assert "is not constant" in caught.value.diagnostics[0].message


@pytest.mark.parametrize("name", ["absorbing_layer", "driven_family"])
def test_energy_is_not_said_to_be_constant_beside_what_drives(name):
    text = (ROOT / "tests" / "cases" / f"{name}.lag").read_text()
    made = compile_model(Source(name, text), symmetric=True)
    assert "energy" not in str(made.structure.symmetries)
    assert not any("Constant along" in file for file in made.files.values())
