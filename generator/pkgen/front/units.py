"""Units and dimensions.

A dimension is a vector of exponents over the seven SI base units: integers, or Fractions after a
root. A unit is an exact factor to SI, a power of pi (so that 180 deg is exactly pi) and a
dimension. Names that are not in the table below are looked up with pint, one at a time, if they
match a strict pattern. pint is imported only then, since its import takes half a second.
"""

from __future__ import annotations

import re
from dataclasses import replace
from difflib import get_close_matches
from fractions import Fraction
from functools import cache
from operator import add, sub

from ..record import record

Dimension = tuple  # Seven exponents, in the order of BASE.

BASE = ("kg", "m", "s", "A", "K", "mol", "cd")
_PINT_BASE = ("kilogram", "meter", "second", "ampere", "kelvin", "mole", "candela")
_PINT_PI = Fraction("3.1415926535897932384626433832795028841971693993751")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,31}")
_ITEM = re.compile(
    r"\s*(?:([A-Za-z][A-Za-z0-9_]*)|1)\s*(?:(?:\^|\*\*)\s*([+-]?[0-9]{1,2})(?![0-9]))?\s*"
)
_SPELT = str.maketrans(
    {"\u00b5": "u", "\u03bc": "u", "\u2126": "ohm", "\u03a9": "ohm", "\u212b": "angstrom",
     "\u00c5": "angstrom"}
)  # fmt: skip


NONE: Dimension = (0,) * len(BASE)

_BARE = re.compile(r"[A-Za-z]\w*(\^-?[0-9]+)?([*/][A-Za-z]\w*(\^-?[0-9]+)?)*")
_MORE = ("deg", "kN", "kJ", "kW", "kPa", "mN", "um", "nm", "us", "kHz", "MHz", "GHz", "bar", "eV")


def bare_unit(text: str, at: int) -> str:
    """Returns the well-known unit, written without brackets, that starts at offset `at` of a text;
    "" if there is none."""
    found = _BARE.match(text, at)
    names = re.findall(r"[A-Za-z]\w*", found.group()) if found else ["?"]
    return found.group() if all(n in _SIMPLE or n in _MORE for n in names) else ""


def bracketed(number: str, unit: str) -> str:
    """Returns the hint that a unit needs brackets."""
    product = f"; a product is written {number}*{unit}" if unit.isalpha() else ""
    return f"a unit stands in square brackets: {number} [{unit}]{product}"


class UnitError(Exception):
    """A unit that does not parse: the message, its position in the text, and a hint."""

    def __init__(self, message: str, start: int, end: int, help: str = ""):
        super().__init__(message)
        self.message, self.start, self.end, self.help = message, start, end, help


@record
class Unit:
    """A unit, which is `factor` * pi^`pi` in SI units. `angle` is the exponent of rad in it, for
    display only."""

    factor: Fraction
    pi: int
    dimension: Dimension
    angle: int
    text: str = ""  # Display text; "" for SI.

    @property
    def shown(self) -> str:
        """The unit for display: as written (a torque in N*m must not become J), else in SI."""
        return self.text or si_text(self.dimension, self.angle)

    @property
    def is_si(self) -> bool:
        return self.factor == 1 and self.pi == 0

    def to_power(self, n: int) -> Unit:
        return Unit(self.factor**n, self.pi * n, power(self.dimension, n), self.angle * n)

    def times(self, other: Unit) -> Unit:
        both = times(self.dimension, other.dimension)
        return Unit(self.factor * other.factor, self.pi + other.pi, both, self.angle + other.angle)


ONE = Unit(Fraction(1), 0, NONE, 0)


def times(a: Dimension, b: Dimension) -> Dimension:
    return (*map(add, a, b),)


def over(a: Dimension, b: Dimension) -> Dimension:
    return (*map(sub, a, b),)


def power(a: Dimension, n: Fraction | int) -> Dimension:
    return tuple(_plain(x * n) if x else 0 for x in a)


def _plain(x: Fraction | int) -> Fraction | int:
    return int(x) if x == int(x) else x


def si_text(a: Dimension, angle: int = 0) -> str:
    """Returns a dimension as text: `kg*m/s^2`, `J`, "". `angle` is an exponent of rad."""
    if a in _SHORT and not angle:
        return _SHORT[a]
    parts = [(n, e) for n, e in zip((*BASE, "rad"), (*a, angle), strict=True) if e]
    if angle > 0:
        parts.insert(0, parts.pop())
    over_line = "*".join(_raised(n, e) for n, e in parts if e > 0)
    under = "".join("/" + _raised(n, -e) for n, e in parts if e < 0)
    return (over_line or ("1" if under else "")) + under


def _raised(name: str, exponent: Fraction | int) -> str:
    if exponent == 1:
        return name
    return f"{name}^{exponent}" if exponent == int(exponent) else f"{name}^({exponent})"


def described(a: Dimension) -> str:
    """Returns a text such as `a force [kg*m/s^2]` or `a pure number`; for a dimension without a
    name, `in [kg*m^3]`."""
    kind = KINDS.get(a)
    if a == NONE:
        return kind
    return f"{kind} [{si_text(a)}]" if kind else f"in [{si_text(a)}]"


@cache
def parse_unit(text: str) -> Unit:
    """Parses a unit such as `kg*m/s^2`; raises UnitError."""
    text = text.translate(_SPELT)
    if not text.strip():
        raise UnitError("an empty unit", 0, len(text), "a pure number needs no unit")
    unit, at, sign = ONE, 0, 1
    while True:
        item = _ITEM.match(text, at)
        if item is None:
            raise _malformed(text, at)
        if item.group(1):
            exponent = sign * int(item.group(2) or 1)
            unit = unit.times(_named(item.group(1), item.start(1)).to_power(exponent))
        at = item.end()
        if at == len(text):
            named = unit.is_si and (unit.angle or unit.dimension != NONE)
            return replace(unit, text=re.sub(r"\s", "", text)) if named else unit
        if text[at] not in "*/" or text.startswith("**", at):
            raise _malformed(text, at)
        sign = 1 if text[at] == "*" else -1
        at += 1


def parsed(text: str) -> Unit | None:
    """Parses a unit; returns None for a wrong one."""
    try:
        return parse_unit(text)
    except UnitError:
        return None


def _malformed(text: str, at: int) -> UnitError:
    rest = text[at:]
    character = rest[:1]
    help = "unit names are joined by * and /, with integer exponents, e.g. [kg*m/s^2]"
    if not character:
        return UnitError("the unit is not complete", max(0, at - 1), at, help)
    if character in "²³⁴":
        help = f"write ^{'²³⁴'.index(character) + 2}"
    elif character == "°":
        help = "write [deg]"
    elif character in "()":
        help = "units have no brackets; / divides by the one name after it, e.g. [J/kg/K]"
    elif character in "·×⋅" or (at and text[at - 1] == " " and _NAME.match(rest)):
        help = "units are joined by *, e.g. [N*m]"
    elif character.isdigit():
        help = "a number belongs before the bracket"
    return UnitError(f"'{text.strip()}' is not a unit", at, at + 1, help)


RATIOS = {"dimensionless", "percent", "permille", "ppm", "count"}


@cache
def _registry():
    import pint

    return pint.UnitRegistry(non_int_type=Fraction)


def _is_odd(registry, name: str) -> bool:
    """Whether pint reads the name as a prefix and a constant, as it reads Pc as 1e15 speeds of
    light."""
    prefix, unit, _ = registry.parse_unit_name(name)[0]
    return bool(prefix) and unit.endswith(("_constant", "speed_of_light"))


@cache
def _look_up(name: str) -> Unit | str:
    """Returns the unit of a name, or an error text."""
    if not _NAME.fullmatch(name):
        return f"'{name}' is not a unit"
    registry = _registry()
    try:
        units = registry.parse_units(name)
        if not all(registry._units[u].is_multiplicative for u in units._units):
            return f"'{name}' has an offset or a logarithm; a model needs a plain unit"
        factor, base = registry.get_base_units(units)
    except Exception:  # pint raises exceptions of many types.
        return f"unknown unit '{name}'"
    exponents = dict(base._units)
    if any(Fraction(x).denominator != 1 for x in exponents.values()) or _is_odd(registry, name):
        return f"unknown unit '{name}'"
    dim = tuple(_plain(Fraction(exponents.get(b, 0))) for b in _PINT_BASE)
    angle = exponents.get("radian", 0)
    if not any(dim) and not angle and not set(units._units) <= RATIOS:
        return f"unknown unit '{name}'"  # pint reads AU as an absorbance unit.
    exact, pi = _without_pi(Fraction(factor))
    return Unit(exact, pi, dim, int(angle) if angle == int(angle) else 0)


def _without_pi(factor: Fraction) -> tuple[Fraction, int]:
    """Splits off the power of pi, which pint has multiplied in as a decimal number."""

    def bits(x: Fraction) -> int:
        return x.numerator.bit_length() + x.denominator.bit_length()

    pi = min((0, 1, -1), key=lambda n: bits(factor / _PINT_PI**n))
    return factor / _PINT_PI**pi, pi


def _named(name: str, at: int) -> Unit:
    if name in _SIMPLE:
        return _SIMPLE[name]
    found = _look_up(name)
    pair = next(((a, b) for a in _JOINED for b in _SIMPLE if a + b == name), None)
    if isinstance(found, Unit):
        if pair is None or found.dimension == _SIMPLE[pair[0]].times(_SIMPLE[pair[1]]).dimension:
            return found
        found = f"unknown unit '{name}'"  # For instance, pint reads Nm as a unit for yarns.
    help = ""
    near = [n for n in (*_SIMPLE, "au") if n.lower() == name.lower()]
    near = near or get_close_matches(name, [*_SIMPLE, "deg", "newton", "joule", "metre"], 1, 0.75)
    if "offset" in found:
        help = "use K for temperatures, pure numbers for ratios"
    elif pair and not (near and near[0].lower() == name.lower()):
        help = f"did you mean '{pair[0]}*{pair[1]}'?"
    elif near:
        help = f"did you mean '{near[0]}'?"
    raise UnitError(found, at, at + len(name), help)


# Units, each after the units in which it is given: factor, unit.
_TABLE = """
g 1/1000 kg; cm 1/100 m; mm 1/1000 m; km 1000 m; ms 1/1000 s; min 60 s; h 3600 s; Hz 1 1/s
N 1 kg*m/s^2; J 1 N*m; W 1 J/s; Pa 1 N/m^2; C 1 A*s; V 1 W/A; F 1 C/V; H 1 V*s/A; T 1 V*s/m^2
Wb 1 V*s; ohm 1 V/A
"""
_SIMPLE = {
    name: Unit(Fraction(1), 0, tuple(int(name == other) for other in BASE), int(name == "rad"))
    for name in (*BASE, "rad")
}
for _name, _factor, _unit in map(str.split, re.split("[;\n]", _TABLE.strip())):
    _SIMPLE[_name] = replace(parse_unit(_unit), factor=Fraction(_factor), text="")
# If such a unit is followed by another unit, the sign * is missing: Nm is a mistake for N*m. T is
# not one of them, since THz, TJ and TW begin with the prefix tera.
_JOINED = ("kg", "N", "J", "W", "Pa", "C", "V", "A", "K")
_SHORT = {_SIMPLE[n].dimension: n for n in ("J", "W", "C", "V", "F", "H", "T", "Wb", "ohm")}

LENGTH, TIME, MASS, INERTIA, ACCELERATION, FORCE, ENERGY, POWER = (
    parse_unit(text).dimension for text in ("m", "s", "kg", "kg*m^2", "m/s^2", "N", "J", "W")
)
_KINDS = """
1 a pure number; m a length; s a time; kg a mass; m/s a speed; m/s^2 an acceleration; N a force
J an energy; W a power; N*s a momentum; J*s an angular momentum; kg*m^2 a moment of inertia
N/m a stiffness; kg/s a damping constant; Hz a rate; Hz^2 a squared rate; m^2 an area
m^3 a volume; m^2/s^2 a squared speed; kg/m^3 a density; Pa a pressure; A a current; C a charge
V a voltage; T a magnetic field; K a temperature
"""
KINDS = {
    parse_unit(unit).dimension: kind
    for unit, kind in (row.split(maxsplit=1) for row in re.split("[;\n]", _KINDS.strip()))
}


def known_units() -> tuple[str, ...]:
    """Returns the units common in models; pint knows more."""
    return (*_SIMPLE, *_MORE)
