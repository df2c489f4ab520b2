"""A potential made of any function of the language, passed at a speed: the run keeps its energy, by
an impulse where it jumps, or ends by a status that names the place."""

from __future__ import annotations

import random
from functools import cache

import pytest

import pkgen
from conftest import case, seeds
from pkgen.functions import FUNCTIONS

# Where V is smooth, or even at the cut, or vanishes there, the run goes on.
SMOOTH = (
    "cos(3*atan2(y, x) - 1)",
    "sin(atan2(y, x))^2",
    "y^3*atan2(y, x)",
    "atan2(y, x)^2",  # whose force jumps, as that of the next
    "y*atan2(y, x)",
)
JUMPS = ("atan2(y, x)", "(atan2(y, x) - 1)^2", "cos(atan2(y, x)/2 - 1)", "x*atan2(y, x)")
MODEL = case("cuts_model")
CASES = [
    *(
        f"{name}({', '.join(('a*s + b', '1 - s')[: len(row.arguments)])})"
        for name, row in FUNCTIONS.items()
        if not (row.internal or row.still or name == "floor")  # refused in a potential
    ),
    *SMOOTH,
    *JUMPS,
]


@pytest.fixture(scope="module")
def load(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cuts")

    @cache
    def load(potential: str):
        path = folder / f"{abs(hash(potential))}.lag"
        path.write_text(MODEL % potential, encoding="utf-8")
        return pkgen.load(path)

    return load


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("seed", seeds(range(3), 9))
@pytest.mark.parametrize("potential", CASES)
def test_no_jump_is_passed_over(load, potential: str, seed: int) -> None:
    draw = random.Random(f"{potential} {seed}")
    grows = potential.startswith(("exp", "sinh", "cosh"))  # without bound: no fixed step follows
    m, method = load(potential), draw.choice(["dop853", "radau", "dop853" if grows else "rk4"])
    m.params["a"], m.params["b"] = draw.uniform(0.3, 1), draw.uniform(0.1, 0.5)
    m.params["c"] = draw.choice([-1, 1]) * draw.uniform(0.1, 1)
    how = {"step": 1e-3} if method == "rk4" else {"rtol": 1e-10}
    try:
        r = m.run(until=4, every=0.1, method=method, start={"s": 0.2, "s'": 3}, **how)
    except pkgen.RunError as ended:
        assert potential not in SMOOTH
        # The last two are said where a potential that grows without bound pushes it away.
        named = ("vanishes at t =", "jumps by 2 pi at t =", "at infinity", "no longer finite")
        assert any(text in str(ended) for text in named)
        r = ended.result
    else:
        assert potential not in JUMPS, "it passed the cut"
    energy, moving = r["energy"], r["s'"] ** 2 / 2  # which grows without bound next to an end
    assert (abs(energy - energy[0]) < 1e-5 * (1 + abs(energy[0]) + moving)).all()
