"""What stands in the options of the command line."""

from fractions import Fraction

import pytest

from pkgen.front.check.options_text import LeftSide, OptionError, left_side, quantity


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [("30 [cm]", "m", Fraction(3, 10)), ("0.3", "m", Fraction(3, 10)), ("0", "kg", 0),
     ("pi/2 + 0.1", "rad", 1.6707963267948966), ("45 [deg]", "rad", 0.7853981633974483),
     ("N + 1", "m", 4), ("sum(i, i = 1..N)", "", 6), ("-1e3", "1/s", -1000),
     ("gravity", "", 7), ("fast + body", "", 5), ("60 [rpm]", "rad/s", 6.283185307179586)],
)  # fmt: skip
def test_values_of_options(text, unit, value):
    assert quantity(
        text, unit, values={"N": 3, "gravity": 7, "fast": 2, "body": 3}
    ) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [("3 [kg]", "3 [kg] is a mass [kg], l is a length [m]"), ("9,81", "a decimal is written"),
     ("2x", "neither a number"), ("x", "unknown name 'x'"), ("1/0", "division by zero"),
     ("9^9^9^9", "an exponent beyond"), ("", "a value is missing"), ("1 +", "a value is missing"),
     ("t", "is the time"), ("[1, 2, 3]", "is a vector"), ("(1", "never closed"),
     ("__import__('os')", ""), ("1\n2", "one value"), ("1" * 2000, "more than 1000"),
     ("3 [foo]", "unknown unit"), ("3 # a", "one value"), ("\0", "NUL")],
)  # fmt: skip
def test_wrong_values_of_options(text, message):
    with pytest.raises(OptionError) as caught:
        quantity(text, "m", name="l")
    assert message in caught.value.text()


def test_left_sides_of_options():
    assert left_side("theta'") == LeftSide("theta", None, 1)
    assert left_side("θ") == LeftSide("theta", None, 0)
    assert left_side("q[N+1]'", {"N": 3}) == LeftSide("q", 4, 1)
    for text in ("a = 3", "a, b", "q[i = 1..2]", "2", "q[x]", "q[1.5]", "tan(R)", ""):
        with pytest.raises(OptionError):
            left_side(text)


@pytest.mark.parametrize("name", ["draw", "view", "fast", "body", "joint", "gravity"])
def test_words_that_start_statements_alone_are_names(name):
    assert left_side(f"{name}[2]'") == LeftSide(name, 2, 1)
