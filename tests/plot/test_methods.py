"""One colour and one marker a method, in all pictures."""

import json
from itertools import combinations

from conftest import run_pkgen
from pkgen.plot import methods, style
from pkgen.plot.names import amount, number


def test_every_method_has_a_mark_of_its_own() -> None:
    listed = {method["name"] for method in json.loads(run_pkgen("methods", "--json").stdout)}
    assert len(listed) > 50 and listed == set(methods.MARKS)
    assert len(set(methods.MARKS.values())) == len(methods.MARKS)


def test_what_is_no_method_of_the_runtime_has_no_mark_of_one() -> None:
    for name in ("mine", "scipy DOP853", "diffrax Tsit5"):
        assert methods.mark(name) == methods.mark(name) not in methods.MARKS.values()


def test_dark_colours_are_told_from_the_ground() -> None:
    for name in methods.MARKS:
        colour, _ = methods.mark(name, dark=True)
        assert contrast(colour, style.DARK_GROUND) > 3, (name, colour)
    for one, other in combinations({methods.mark(n, True)[0] for n in methods.MARKS}, 2):
        assert one != other


def contrast(one: str, other: str) -> float:
    """Of two colours, as the W3C has it (Web Content Accessibility Guidelines 2.1, 1.4.3)."""
    bright, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (bright + 0.05) / (dark + 0.05)


def luminance(colour: str) -> float:
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in parts]
    return sum(w * x for w, x in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def test_numbers_and_amounts() -> None:
    shown = [number(x) for x in (1e-3, 0.25641, 6.31e-6, 1e-12, 0.1, 12345.0, 1.0, 9.999e-7)]
    assert shown == ["10⁻³", "0.256", "6.31·10⁻⁶", "10⁻¹²", "0.1", "1.23·10⁴", "1", "10⁻⁶"]
    assert amount("1.5", "kg*m/s^2") == "1.5\u00a0kg·m/s²" and amount("1.5", "") == "1.5"
