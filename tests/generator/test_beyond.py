"""Constants that no double holds are errors of the model, wherever they come from."""

import random
import re
from fractions import Fraction

import pytest

from pkgen.compiler import check_model, compile_model
from pkgen.front.read import from_text
from pkgen.source import ModelError

MODEL = """model m
size N = {size}
const w = {value}
param k = 2
coord x
coord q[1..N]
periodic q
kinetic x'^2/2 + sum(q[i]'^2/2, i = 1..N)
potential x^2/2 + sum((q[i+1] - q[i])^2/2, i = 1..N)
"""
PLACES = [
    "potential w*x^2",
    "potential k*w*x^100",
    "potential cos(w*x)",
    "potential sum(w*(q[i+1] - q[i])^3, i = 1..N)",
    "potential sum(cos(w*q[i]), i = 1..N)",
    "kinetic w*cos(x)^2*x'^2",
    "kinetic (2 + sin(w*x))*x'^2",
    "dissipation w*x'^2",
    "force x = w*(w*sin(x))",
    "force x = exp(w*x)/w",
    "observe o = (w*x)^2*(w*x')",
    "event e: sin(w*(w*x)) rising",
    "start x = w/k",
    "param c = w*w*k",
    "param c = 0 in (-w, w)",
    "let z = w*x\nobserve o = z'^3*7",
    "scene s\nset k = w*w\nuntil 1\nmethod rk4 step 0.1\nend",
]
LEAST, MOST = Fraction(2) ** -1022, Fraction(2) ** 1024


def constants(text: str) -> list[Fraction]:
    return [Fraction(number) for number in re.findall(r"PK_C\(([0-9.]+(?:e-?[0-9]+)?)\)", text)]


@pytest.mark.parametrize("place", PLACES)
def test_a_constant_is_in_range_or_an_error_with_its_place(place: str) -> None:
    draw = random.Random(place)
    refused = written = 0
    for exponent in (*draw.sample(range(60, 308), 2), 10, 308):
        for sign in "-", "":
            value = f"{draw.randint(1, 9)}e{sign}{min(exponent, 307) if sign else exponent}"
            value = value if exponent < 308 else f"1e{sign}{307 if sign else 308}"
            size = 3 if "event" in place else draw.choice((3, 200))
            source = from_text("m.lag", MODEL.format(size=size, value=value) + place + "\n")
            try:
                files = compile_model(source).files
            except ModelError as wrong:
                refused += 1
                assert "double" in wrong.diagnostics[0].message
                with pytest.raises(ModelError):
                    check_model(source)
                continue
            written += 1
            found = constants(files["m.c"])
            assert all(LEAST <= abs(x) < MOST for x in found if x)
            beyond = any(not 2.0**-126 <= x < 2.0**128 for x in found if x)
            assert beyond <= ("that float cannot hold" in files["m.h"])
    assert written  # at the smallest exponent
    assert refused or "(w*" in place or place.startswith(("start", "param c = 0", "scene"))
