"""Units: text to a factor, a power of pi and a dimension."""

from fractions import Fraction

import pint
import pytest

from pkgen.front import units
from pkgen.front.units import NONE, UnitError, described, parse_unit, si_text


def dimension(*exponents: int) -> tuple[int, ...]:
    return (*exponents, *[0] * (7 - len(exponents)))


@pytest.mark.parametrize(
    ("text", "factor", "pi", "dim"),
    [
        ("kg*m/s^2", 1, 0, units.FORCE),
        ("N", 1, 0, units.FORCE),
        ("kN*mm", 1, 0, units.ENERGY),
        ("km/h", Fraction(5, 18), 0, dimension(0, 1, -1)),
        ("J/kg/K", 1, 0, dimension(0, 2, -2, 0, -1)),  # from left to right
        ("1/s", 1, 0, dimension(0, 0, -1)),
        ("m**2", 1, 0, dimension(0, 2)),
        ("kg*m^-1", 1, 0, dimension(1, -1)),
        ("deg", Fraction(1, 180), 1, NONE),
        ("rpm", Fraction(1, 30), 1, dimension(0, 0, -1)),
        ("µm", Fraction(1, 10**6), 0, units.LENGTH),
        ("Ω", 1, 0, dimension(1, 2, -3, -2)),
        ("min", 60, 0, units.TIME),
        ("h", 3600, 0, units.TIME),
        ("inch", Fraction(127, 5000), 0, units.LENGTH),
        ("THz", 10**12, 0, dimension(0, 0, -1)),  # T is tera before it is tesla
        ("TW", 10**12, 0, units.POWER),
        ("mT*m", Fraction(1, 1000), 0, dimension(1, 1, -2, -1)),
        ("eV", Fraction(801088317, 5 * 10**27), 0, units.ENERGY),
    ],
)
def test_reads(text, factor, pi, dim):
    unit = parse_unit(text)
    assert (unit.factor, unit.pi, unit.dimension) == (factor, pi, dim)


@pytest.mark.parametrize(
    ("text", "message", "help"),
    [
        ("foo", "unknown unit 'foo'", ""),
        ("Nm", "unknown unit 'Nm'", "did you mean 'N*m'?"),  # yarn, says pint
        ("AU", "unknown unit 'AU'", "did you mean 'au'?"),  # absorbance, says pint
        ("Pc", "unknown unit 'Pc'", ""),  # a petaspeed of light
        ("G", "unknown unit 'G'", ""),  # gauss: exponents of a half
        ("Kg", "unknown unit 'Kg'", "did you mean 'kg'?"),
        ("degC", "has an offset", "use K"),
        ("dB", "has an offset or a logarithm", ""),
        ("J/(kg*K)", "is not a unit", "no brackets"),
        ("m²", "is not a unit", "write ^2"),
        ("kg m", "is not a unit", "joined by *"),
        ("m/", "not complete", ""),
        ("", "empty", ""),
        ("m^999", "is not a unit", ""),
        ("m^0.5", "is not a unit", "integer exponents"),
        ("__import__('os')", "is not a unit", ""),
        ("a" * 5000, "is not a unit", ""),
    ],
)
def test_refuses(text, message, help):
    with pytest.raises(UnitError) as caught:
        parse_unit(text)
    assert message in caught.value.message
    assert help in caught.value.help
    assert 0 <= caught.value.start <= caught.value.end <= len(text)


def test_the_table_agrees_with_pint():
    registry = pint.UnitRegistry(non_int_type=Fraction)
    for name, unit in units._SIMPLE.items():
        theirs, base = registry.get_base_units(registry.parse_units(name))
        exponents = dict(base._units)
        assert (unit.factor, unit.pi) == (theirs, 0), name
        assert unit.dimension == tuple(exponents.get(b, 0) for b in units._PINT_BASE), name
        assert unit.angle == exponents.get("radian", 0), name


@pytest.mark.parametrize(
    ("dim", "angle", "text"),
    [
        (NONE, 0, ""),
        (NONE, 1, "rad"),
        (dimension(0, 0, -1), 1, "rad/s"),
        (dimension(0, 0, -1), 0, "1/s"),
        (units.FORCE, 0, "kg*m/s^2"),
        (units.ENERGY, 0, "J"),
        (units.POWER, 0, "W"),
        (dimension(0, Fraction(1, 2)), 0, "m^(1/2)"),
        (dimension(1, 2, -1), 0, "kg*m^2/s"),
    ],
)
def test_si_text(dim, angle, text):
    assert si_text(dim, angle) == text
    if "(" not in text and text:
        assert parse_unit(text).dimension == dim  # what is shown can be read again


def test_described():
    assert described(units.FORCE) == "a force [kg*m/s^2]"
    assert described(units.ENERGY) == "an energy [J]"
    assert described(NONE) == "a pure number"
    assert described(dimension(3, 1)) == "in [kg^3*m]"
