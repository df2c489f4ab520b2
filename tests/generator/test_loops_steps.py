"""Fused steps of several families of unequal lengths beside kicks and drifts one by one."""

import random

import pytest
from loop_harness import Looped
from test_loops import METHODS, fused, one_by_one

from conftest import seeds

LENGTHS = ["1..N", "1..N+3", "2..N-4", "1..700"]


def model(r: random.Random) -> str:
    """Chains with ends of each kind, bonds up to two members long, single forces."""
    lines = ["model steps", "size N = 31"]
    for name in "qrs"[: r.randint(1, 3)]:
        length = r.choice(LENGTHS[:1] if name == "q" else [*LENGTHS, "1..700"])
        lo, hi = length.split("..")
        lines.append(f"coord {name}[{length}]")
        kind, first, last = r.choice(["free", "free", "fixed", "ring", "none"]), lo, f"{hi}-1"
        if kind == "free":
            lines.append(f"free {name}[{hi}+1]")
            last = hi
        elif kind == "fixed":
            lines.append(f"fixed {name}[{hi}+1] = 0.1*sin(t)")
            last = hi
        elif kind == "ring":
            lines.append(f"periodic {name}")
            last = hi
        mass = r.choice(["1", f"(1 + 0.3*sin(i))*{r.choice([1, 2])}"])
        lines.append(f"kinetic sum({mass}*{name}[i]'^2/2, i = {lo}..{hi})")
        bond = r.choice([f"{name}[i+1] - {name}[i]", f"sin({name}[i+1] - {name}[i])"])
        lines.append(f"potential sum(({bond})^4 + {name}[i]^2/2, i = {first}..{last})")
        if r.random() < 0.7:
            bond = f"{name}[i+2] - 2*{name}[i+1] + {name}[i]"
            last = f"{hi}-1" if kind == "free" else f"{hi}-2"  # beyond the free end
            lines.append(f"potential sum(({bond})^4/9, i = {lo}..{last})")
        if r.random() < 0.3:
            lines.append(f"force {name}[{r.choice([lo, hi, f'{lo}+7'])}] = cos(t)")
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("seed", seeds(range(40), turning=20))
def test_fused_steps_of_unequal_families(seed, tmp_path):
    r = random.Random(seed)
    text = model(r)
    loops = Looped(text, tmp_path)
    if not hasattr(loops.library, "steps_advance"):
        return
    kick, drift = METHODS[r.choice(["symplectic_euler", "verlet"])]
    for size in (16, 65, *r.sample(range(250, 1100), 2), *r.sample(range(481, 530, 8), 3)):
        at = loops.at(size)
        q, v = ([r.uniform(-0.5, 0.5) for _ in range(at.n)] for _ in range(2))
        expected = one_by_one(at, kick, drift, 0.3, 0.02, 4, q, v)
        for one, other in zip(expected, fused(at, kick, drift, 0.3, 0.02, 4, q, v), strict=True):
            off = max(abs(x - y) for x, y in zip(one, other, strict=True))
            assert off < 1e-11, f"{text}N = {size}: {off}"
