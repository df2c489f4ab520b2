"""What a unit belongs to: items as people write them, beside the same with brackets."""

import random

import pytest

from conftest import case, seeds
from pkgen.compiler import check_model
from pkgen.front.read import from_text
from pkgen.graph.differentiate import symbols_in
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import BIT, Kind
from pkgen.middle.derive.derive import derive
from pkgen.source import ModelError

HEAD = case("units_written_m")
WRITTEN = [
    ("x - 0.1 [m]", "x - (0.1 [m])"),
    ("x - 10 [cm]", "x - (0.1 [m])"),
    ("x' - 100 [m/s]", "x' - (100 [m/s])"),
    ("2 [N]*cos(w*t)", "(2 [N])*cos(w*t)"),
    ("1/2 [m]", "0.5*(1 [m])"),
    ("2*pi/3 [rad]", "2*pi/3"),
    ("1 - 0.3 [m]", "0.7*(1 [m])"),
    ("l/2 [m]", "l/2"),
    ("th - 5 [deg]", "th - pi/36"),
    ("x + 2*pi/c [m]", "x + (2*pi/3)*(1 [m])"),
    ("1 - 0.3 [m] + x", "x + 0.7*(1 [m])"),
    ("sin(w*t) - 0.5 [m]", "(sin(w*t) - 0.5)*(1 [m])"),
    ("x/l [m]", "(x/l)*(1 [m])"),
    ("-2 [N]*x", "-(2 [N])*x"),
    ("3 [N/m]*x + 2 [N]*sin(th)", "(3 [N/m])*x + (2 [N])*sin(th)"),
    ("F*2 [m]", "F*(2 [m])"),
    ("F - x*2 [N/m]", "F - x*(2 [N/m])"),
    ("(x - 5 [mm])^2", "(x - (0.005 [m]))^2"),
    ("max(x, 2 [cm])", "max(x, (0.02 [m]))"),
    ("sqrt(x^2 + 4 [m^2])", "sqrt(x^2 + (4 [m^2]))"),
]


def values(texts: list[str]) -> list[float]:
    lines = "".join(f"observe o{k} = {text}\n" for k, text in enumerate(texts))
    model, _ = check_model(from_text("m.lag", HEAD + lines + "start x = 0.7, th = 0.4, x' = 0.3\n"))
    e = derive(model)
    draw, symbols = random.Random(1), {}
    kinds = (Kind.COORDINATE, Kind.RATE, Kind.PARAMETER, Kind.TIME)
    for symbol in symbols_in(e.graph, e.observed, sum(BIT[kind] for kind in kinds)):
        symbols[symbol] = draw.uniform(0.3, 2)
    return evaluate(e.graph, e.observed, symbols)


def test_as_people_write_them():
    found = values([text for pair in WRITTEN for text in pair])
    for (written, bracketed), a, b in zip(WRITTEN, found[::2], found[1::2], strict=True):
        assert a == pytest.approx(b, rel=1e-14), (written, bracketed)


@pytest.mark.parametrize("seed", seeds(range(3), 2))
def test_the_longest_piece_of_numbers_before_it(seed):
    """x ± numbers [unit] ± terms, each piece a random product of numbers and constants."""
    draw, pairs = random.Random(seed), []
    for _ in range(60):
        number = "*".join(
            draw.choice(("2", "0.3", "c", "pi", "1/3")) for _ in range(draw.randint(1, 3))
        )
        unit, factor = draw.choice((("m", 1), ("cm", 0.01), ("mm", 0.001)))
        terms = [(draw.choice("+-"), number) for _ in range(draw.randint(1, 2))]
        written = "x" + "".join(f" {sign} {text}" for sign, text in terms) + f" [{unit}]"
        brackets = "x" + "".join(f" {sign} {factor}*({text})*(1 [m])" for sign, text in terms)
        if draw.random() < 0.5:
            written, brackets = f"{written} + l", f"{brackets} + l"
        pairs += [written, brackets]
    found = values(pairs)
    for k in range(0, len(pairs), 2):
        assert found[k] == pytest.approx(found[k + 1], rel=1e-13), pairs[k]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("F/2 [m]", "after a division: is it the unit of 2, or of the whole?"),
        ("x - sin(w*t) [m]", "unit mismatch"),
        ("F*x [m]", "unit mismatch: F*x is an energy"),
        ("x + 2 [N]", "unit mismatch"),
        ("2 [m]^2", "put it in brackets"),
        ("2 [m] x", "an operator is missing after the unit [m]"),
    ],
)
def test_what_is_not_clear_is_asked_for(text, words):
    with pytest.raises(ModelError) as said:
        check_model(from_text("m.lag", HEAD + f"observe o = {text}\n"))
    assert words in said.value.text()
