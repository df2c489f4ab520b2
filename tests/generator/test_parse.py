"""Text to statements: precedence, brackets, comments, scenes, limits."""

from fractions import Fraction

import pytest

from conftest import case
from pkgen import limits
from pkgen.front import statements
from pkgen.front.parse import parse, parse_all
from pkgen.front.read import UnreadableModel, from_text, read
from pkgen.source import ModelError
from pkgen.tree import (
    Add,
    Call,
    Component,
    Expr,
    Multiply,
    Name,
    Negate,
    Number,
    Power,
    Prime,
    Quantity,
    Sum,
    Vector,
)


def shape(expr: Expr) -> object:
    """An expression without its places."""
    match expr:
        case Number(value=value):
            return value
        case Name(id=name, index=None):
            return name
        case Name(id=name, index=index):
            return ("index", name, shape(index))
        case Prime(of=of):
            return ("'", shape(of))
        case Component(of=of, axis=axis):
            return (".", shape(of), axis)
        case Negate(of=of):
            return ("-", shape(of))
        case Add(terms=terms, signs=signs):
            return ("+", signs, *map(shape, terms))
        case Multiply(factors=factors, exponents=exponents):
            return ("*", exponents, *map(shape, factors))
        case Power(base=base, exponent=exponent):
            return ("^", shape(base), shape(exponent))
        case Call(function=function, arguments=arguments):
            return (function, *map(shape, arguments))
        case Sum(body=body, ranges=ranges):
            return ("sum", shape(body), *((r.variable, shape(r.lo), shape(r.hi)) for r in ranges))
        case Vector(items=items):
            return ("[]", *map(shape, items))
        case Quantity(of=of, unit=unit):
            return ("unit", shape(of), unit)
    raise TypeError(expr)


def parsed(text: str) -> object:
    (statement,) = parse(from_text("test.lag", f"let r = {text}")).statements
    return shape(statement.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a - b + c", ("+", (1, -1, 1), "a", "b", "c")),
        ("a/b*c", ("*", (1, -1, 1), "a", "b", "c")),
        ("-x^2", ("-", ("^", "x", 2))),
        ("-x*y", ("*", (1, 1), ("-", "x"), "y")),
        ("a*-b", ("*", (1, 1), "a", ("-", "b"))),
        ("a^b^c", ("^", "a", ("^", "b", "c"))),
        ("a**-2", ("^", "a", ("-", 2))),
        ("a^-b^c", ("^", "a", ("-", ("^", "b", "c")))),
        ("x'^2", ("^", ("'", "x"), 2)),
        ("-x'", ("-", ("'", "x"))),
        ("q[i+1]'", ("'", ("index", "q", ("+", (1, 1), "i", 1)))),
        ("(a + b)'", ("'", ("+", (1, 1), "a", "b"))),
        ("sin(x)'", ("'", ("sin", "x"))),
        ("[a, b, 0].y'", ("'", (".", ("[]", "a", "b", 0), 1))),
        ("P'.z", (".", ("'", "P"), 2)),
        ("1/2 [m]", ("unit", ("*", (1, -1), 1, 2), "m")),
        ("(2 [N])*cos(t)", ("*", (1, 1), ("unit", 2, "N"), ("cos", "t"))),
        ("cos(30 [deg])", ("cos", ("unit", 30, "deg"))),
        ("9.81[m/s^2]", ("unit", Fraction(981, 100), "m/s^2")),
        ("x [m]", ("unit", "x", "m")),
        ("1.5e-3", Fraction(3, 2000)),
        ("2e3", 2000),
        ("sum(q[i]^2, i = 1..N, j = i+1..N)",
         ("sum", ("^", ("index", "q", "i"), 2), ("i", 1, "N"), ("j", ("+", (1, 1), "i", 1), "N"))),
        ("sin", "sin"),  # a function only before a bracket
        ("step(x)", ("step", "x")),
        ("+x", "x"),
    ],
)  # fmt: skip
def test_expressions(text, expected):
    assert parsed(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [("θ1", "theta1"), ("ϑ", "theta"), ("ϕ", "phi"), ("ϵ", "epsilon"), ("Ω0", "Omega0"),
     ("\u2126", "Omega"), ("\u00b5", "mu"), ("λ", "lambda"), ("𝜔", "omega"), ("αβ", "alphabeta"),
     ("ς", "sigma")],
)  # fmt: skip
def test_greek_is_spelt_out(text, expected):
    assert parsed(text) == expected


def test_places_count_characters():
    source = from_text("test.lag", "let ψ = θ*(α + )")
    with pytest.raises(ModelError) as caught:
        parse(source)
    assert source.position(caught.value.diagnostics[0].span.start) == (1, 16)


def test_intervals_close_with_either_bracket():
    text = "param a = 1 in (0, 2]\nparam b = 1 [m] in [0, inf)\nparam c = 1 in (-inf, 3 [m])"
    a, b, c = (s.interval for s in parse(from_text("test.lag", text)).statements)
    assert (a.lo_open, a.hi_open) == (True, False)
    assert (b.lo_open, b.hi_open) == (False, True)
    assert isinstance(c.hi, Quantity)


def test_a_line_goes_on_while_a_bracket_is_open():
    text = "let a = (1 +  # first\n   2)   # last\nlet b = 3"
    a, b = parse(from_text("test.lag", text)).statements
    assert shape(a.value) == ("+", (1, 1), 1, 2)
    assert (a.description, b.description) == ("last", "")


def test_descriptions_are_clean_and_short():
    text = "let a = 1 # one \x07 \u202e two\t three\n# alone\nlet b = 2\nlet c = 3 # " + "x" * 999
    a, b, c = parse(from_text("test.lag", text)).statements
    assert a.description == "one two three"
    assert b.description == ""
    assert len(c.description) == 200


def test_every_statement_of_the_language_parses():
    text = case("parse_m")
    file = parse(from_text("test.lag", text))
    assert len(file.statements) == 33
    scene = file.statements[-1]
    assert isinstance(scene, statements.Scene)
    assert (scene.name, scene.description, len(scene.clauses)) == ("one", "described", 14)
    assert isinstance(scene.clauses[5], statements.Method)
    assert [s.keyword for s in file.statements if isinstance(s, statements.Single)] == [
        "kinetic", "potential", "lagrangian", "dissipation",
    ]  # fmt: skip
    event = next(s for s in file.statements if isinstance(s, statements.Event))
    assert (event.direction, event.stop) == ("rising", True)


def test_errors_of_several_statements_and_what_they_would_have_declared():
    text = "param a = .5\nlet b = 2x\ncoord c, d[rad]\nlet e = 1"
    file = parse_all(from_text("test.lag", text))
    assert len(file.diagnostics) == 3
    assert [b.names for b in file.broken][:2] == [("a",), ("b",)]
    assert {"c", "d"} <= set(file.broken[2].names)
    assert [s.left.name for s in file.statements] == ["e"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("let a = " + "(" * 10_000 + "x" + ")" * 10_000, "more than 100 deep"),
        ("let a = " + "[" * 10_000, "more than 100 deep"),
        ("let a = " + "sin(" * 101 + "x" + ")" * 101, "more than 100 deep"),
        ("let a = " + "-" * 10_000 + "x", "more than 100 deep"),
        ("let a = x" + "'" * 10_000, "more than 100 deep"),
        ("let a = x" + "^2" * 10_000, "more than 100 deep"),
        ("let a = " + "+".join(["x"] * 200_000), "more than 400000 words"),
        ("let a = " + "+".join(["x"] * 150_000), "more than 100000 numbers"),
        ("let a = 1\n" * 20_001, "more than 20000 statements"),
        ("let a = " + "1" * 500, "500 digits"),
        ("let a = 1e1000000000", "no double holds"),
        ("x" * 1_000_001, "larger than"),
        ("let " + "a" * 64 + " = 1", "64 characters"),
    ],
    ids=lambda value: value[:24],
)
def test_limits(text, message):
    with pytest.raises(ModelError) as caught:
        parse(from_text("test.lag", text))
    assert any(message in d.message for d in caught.value.diagnostics)


def test_just_within_the_limits():
    depth = limits.DEPTH - 2
    parse(from_text("test.lag", "let a = " + "(" * depth + "x" + ")" * depth))
    parse(from_text("test.lag", "let a = " + "+".join(["x"] * 90_000)))
    parse(from_text("test.lag", "let " + "a" * limits.NAME_LENGTH + " = " + "1" * 300))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"model \xff\xfe", "line 1 is not UTF-8"),
        ("model a".encode("utf-16"), "UTF-16"),
        (b"a\0b", "NUL"),
        (b"x" * 1_000_001, "larger than 1,000,000 bytes"),
    ],
)
def test_files_that_are_no_text(tmp_path, data, message):
    path = tmp_path / "a.lag"
    path.write_bytes(data)
    with pytest.raises(ModelError) as caught:
        read(path)
    assert message in caught.value.text()


def test_paths_that_are_no_file(tmp_path):
    paths = {
        tmp_path: "a directory",
        tmp_path / "none": "no such file",
        "/dev/zero": "not a regular file",
        "a\0b": "cannot read",
    }
    for path, message in paths.items():
        with pytest.raises(UnreadableModel) as caught:
            read(path)
        assert message in caught.value.text()


def test_line_ends_and_the_byte_order_mark(tmp_path):
    path = tmp_path / "a.lag"
    path.write_bytes(b"\xef\xbb\xbfmodel a\r\ncoord x\rcoord y\n")
    assert read(path).text == "model a\ncoord x\ncoord y\n"
