"""Statements to a Model: what comes out of a right model, and the warnings."""

import re
from fractions import Fraction
from pathlib import Path

import pytest

from conftest import case
from pkgen.front.check.check import check_text
from pkgen.front.read import from_text, read
from pkgen.source import ModelError
from pkgen.tree import Multiply, Name, Number, Quantity, children

ROOT = Path(__file__).parents[2]
HEAD = case("test")


def model_of(text: str, **sizes: int):
    return check_text(from_text("test.lag", text), sizes)[0]


def errors_of(text: str, **sizes: int) -> list[str]:
    with pytest.raises(ModelError) as caught:
        check_text(from_text("test.lag", text), sizes)
    return [d.message for d in caught.value.diagnostics]


def warnings_of(text: str) -> list[str]:
    return [w.message for w in check_text(from_text("test.lag", text))[1]]


def nodes(model):
    """Every expression of a model."""
    definitions = (*model.definitions, *model.observed, *model.conserved)
    waiting = [*model.kinetic, *model.potential, *model.lagrangian, *model.dissipation]
    waiting += [x.value for x in (*definitions, *model.forces, *model.starts)]
    waiting += [p.default for p in model.parameters]
    waiting += [e for p in model.parameters for e in (p.bounds.lo, p.bounds.hi) if e is not None]
    waiting += [e.value for e in model.ends if e.value is not None]
    while waiting:
        expr = waiting.pop()
        yield expr
        waiting.extend(children(expr))


@pytest.mark.parametrize("path", sorted((ROOT / "models").rglob("*.lag")), ids=lambda p: p.stem)
def test_the_models_are_right(path):
    model, warnings = check_text(read(path))
    assert model.name == path.stem
    assert model.description
    # its potential bends on purpose
    assert not warnings or path.stem == "bilinear_spring"
    assert not any(isinstance(e, Quantity) for e in nodes(model))


def test_an_end_of_bounds_is_the_double_that_is_set():
    """-0.1 is not the fraction -1/10."""
    text = HEAD + "param p = 0 in [-0.1, 0.1]\nscene a\n set p = -0.1\n until 1\nend\n"
    assert model_of(text).scenes[0].assignments


def test_units_become_factors():
    model = model_of(HEAD + "param a = 30 [cm]\nparam b = 48 [deg]\nparam c = 2*m [kg]\n")
    a, b, c = model.parameters[3:]
    assert (a.default.value, a.unit) == (Fraction(3, 10), "m")
    assert (b.unit, c.unit) == ("rad", "kg")
    assert isinstance(b.default, Multiply)
    assert [f.value for f in b.default.factors[:2]] == [Fraction(1, 180), 48]
    assert b.default.factors[2].id == "pi"
    assert not any(isinstance(e, Quantity) for e in nodes(model))


def test_a_unit_belongs_to_the_whole_pure_number_before_it():
    text = "let a = 0.3*sin(theta) [cm]\npotential (1 [N])*a\nobserve o = theta [deg]\n"
    model = model_of(HEAD + text)
    (a,) = model.definitions
    assert a.value.factors[0].value == Fraction(1, 100)
    # An angle is in radians already; [deg] only checks that it is one.
    (o,) = model.observed
    assert o.value == Name("theta", None, o.value.span)


def test_units_for_display():
    model = model_of(HEAD + "input F [N]\nforce x = F\nobserve E = m*g*x\nobserve o = theta'\n")
    x, theta = model.coordinates
    assert (x.unit, x.rate_unit, x.momentum_unit) == ("m", "m/s", "kg*m/s")
    assert (theta.unit, theta.rate_unit, theta.momentum_unit) == ("rad", "rad/s", "kg*m^2/s")
    assert [o.unit for o in model.observed] == ["J", "1/s"]
    assert model.inputs[0].units == ("N",)


@pytest.mark.parametrize("text", ["coord x\n", "coord x [rad]\n", "coord x [deg]\n"])
def test_a_model_without_dimensions(text):
    model = model_of("model test\n" + text + "kinetic x'^2/2\npotential -cos(x) + x*t\n")
    assert model.dimensionless
    assert model.coordinates[0].momentum_unit == ""


def test_a_model_with_one_unit_has_units():
    text = "model test\nparam m = 1 [kg]\ncoord x\nkinetic m*x'^2/2\n"
    assert errors_of(text) and "unit mismatch" in errors_of(text)[0]


def test_units_of_scenes_do_not_count():
    text = "model test\ncoord x\nkinetic x'^2/2\nscene a\n  until 5 [s]\nend\n"
    model = model_of(text)
    assert model.dimensionless
    assert [s.name for s in model.scenes] == ["a"]


def test_bare_numbers_take_the_unit_of_their_target():
    model = model_of(
        HEAD + "size N = 3\ncoord q[1..N] [m]\nkinetic sum(m*q[i]'^2, i = 1..N)\n"
        "fixed q[0] = 0.3, q[N+1] = l\nparam k = 2 [N/m] in [1, 5)\npotential k*q[0]*q[4]\n"
        "start x = pi/2 + 0.1, x' = 0.2*sqrt(2), q[i = 1..N] = sin(pi*i/(N+1)), theta = 10 [deg]\n"
    )
    assert len(model.starts) == 4
    assert [e.index for e in model.ends] == [0, 4]
    message = errors_of(HEAD + "start x = 0.1 + m\n")[-1]
    assert "m is a mass [kg], x is a length [m]" in message


def test_a_literal_zero_fits_any_unit():
    model_of(HEAD + "let P = [x, 0, 0]\npotential m*g*(P.x + 0)\nforce x = 0\nparam c = 0 [m]\n")


@pytest.mark.parametrize(
    ("text", "orders"),
    [("", [0]), ("let v = u'\nkinetic m/2*v^2\n", [1]), ("kinetic m/2*(x + u)'^2\n", [1]),
     ("force x = m*u''\n", [2]), ("let v = u'\nforce x = m*v'\n", [2])],
)  # fmt: skip
def test_the_highest_derivative_of_an_input(text, orders):
    model = model_of(HEAD + "input u [m]\n" + text)
    assert [i.order for i in model.inputs] == orders
    assert model.inputs[0].units == ("m", "m/s", "m/s^2")[: orders[0] + 1]


def test_members_of_definitions_one_after_the_other():
    model = model_of(
        HEAD + "size N = 3\ncoord q[1..N] [m]\nlet X[0] = 0\nlet X[i = 1..N] = X[i-1] + q[i]\n"
        "kinetic sum(m/2*X[i]'^2, i = 1..N)\n"
    )
    first, rest = model.definitions
    assert (first.index.value, first.range) == (0, None)
    assert (rest.index, rest.range.variable) == (None, "i")


def test_vectors():
    model_of(
        HEAD + "let P = [x, 0, -l*cos(theta)]\nlet v = P'\nkinetic m/2*dot(v, v)\n"
        "kinetic m/2*dot(P', P')\nobserve n = norm(P) [m]\nobserve w = cross(P, v).y [m^2/s]\n"
        "let Q = 2*P - P/3 + x*P/l\npotential m*g*Q.z\n"
    )


def test_sizes():
    text = (
        "model test\nsize N = 3\nsize M = 2*N\ncoord q[1..M]\nkinetic sum(q[i]'^2, i = 1..M)\n"
        "potential sum(q[i]*q[i+1], i = 1..M-1)\n"
    )
    assert [s.value for s in model_of(text).sizes] == [3, 6]
    assert [s.value for s in model_of(text, N=5).sizes] == [5, 10]
    assert "no size 'K'" in errors_of(text, K=5)[0]
    assert "at least 1" in errors_of(text, N=0)[0]


@pytest.mark.parametrize(
    ("ends", "right"),
    [("", False), ("fixed q[0] = 0\n", False), ("fixed q[0] = 0, q[N+1] = 0\n", True),
     ("free q\n", True), ("free q[0]\nfixed q[4] = sin(t)\n", True), ("periodic q\n", True)],
)  # fmt: skip
def test_ends(ends, right):
    text = (
        "model test\nsize N = 3\ncoord q[1..N]\nkinetic sum(q[i]'^2, i = 1..N)\n"
        "potential sum((q[i+1] - q[i])^2, i = 0..N)\n" + ends
    )
    if right:
        assert model_of(text).ends
    else:
        assert any("outside the family" in m for m in errors_of(text))


def test_parameters_that_follow():
    model = model_of(HEAD + "const c = 2\nparam a = 3*m\nparam b = c*2 + sin(1)\nparam d = a\n")
    assert [p.follows for p in model.parameters] == [False, False, False, True, False, True]


def test_declared_names_hide_the_built_in_ones():
    model = model_of(HEAD + "let T = x\nobserve o = T [m]\nobserve e = V\n")
    assert [o.unit for o in model.observed] == ["m", "J"]


def test_names_of_functions_are_names():
    model = model_of(HEAD + "let sin = x\nlet sum = sin(theta)*x\npotential m*g*(sin + sum)\n")
    assert [d.name for d in model.definitions] == ["sin", "sum"]


def test_the_momentum_of_a_family():
    text = "model test\ncoord q[1..3] [m]\nparam m = 1 [kg]\nkinetic sum(m*q[i]'^2, i = 1..3)\n"
    model = model_of(text + "conserve P = sum(p_q[i], i = 1..3)\nobserve o = p_q[2]\n")
    assert model.observed[0].unit == "kg*m/s"
    assert errors_of(text + "observe o = p_q\n")


@pytest.mark.parametrize(
    ("text", "warning"),
    [
        ("param unused = 1\n", "'unused' is never used"),
        ("let unused = x\n", "'unused' is never used"),
        ("potential m*g*abs(x)\n", "contains abs of the motion"),
        ("let a = max(x, l)\npotential m*g*a\n", "contains max of the motion"),
        ("observe a = x [cm]\n", "is only checked"),
        ("coord y [cm]\nkinetic m*y'^2\n", "are in SI, [m], not in [cm]"),
        ("conserve c = 3\n", "always conserved"),
    ],
)
def test_warnings(text, warning):
    assert any(warning in w for w in warnings_of(HEAD + text))
    assert not any(warning in w for w in warnings_of(HEAD))


def test_abs_of_what_does_not_move_is_no_reason_to_warn():
    assert not any("abs" in w for w in warnings_of(HEAD + "potential m*abs(g)*x\n"))


def test_errors_of_one_kind_do_not_hide_another():
    found = errors_of(
        "model test\nparam a = .5\nparam m = 1 [kg] in (2, 3)\ncoord x, y [m]\nkinetic m*x'^2\n"
        "potential m*x\nstart z = 1\nlet b = a + 1\n"
    )
    for part in ("digits on both sides", "outside its bounds", "'y' has no inertia",
                 "potential needs an energy", "unknown coordinate 'z'"):  # fmt: skip
        assert sum(part in message for message in found) == 1, part
    assert len(found) == 5  # and nothing about a


def test_too_many_errors_are_counted():
    text = HEAD + "".join(f"let a{i} = b{i}\n" for i in range(60))
    with pytest.raises(ModelError) as caught:
        check_text(from_text("test.lag", text))
    assert (len(caught.value.diagnostics), caught.value.more) == (50, 10)
    assert caught.value.text().endswith("test.lag: and 10 more errors")


def test_the_error_of_the_manual():
    """The example at the end of LANGUAGE.md, to the letter."""
    path = Path(__file__).with_name("wrong") / "energy_units.txt"
    message = path.read_text(encoding="utf-8").replace("energy_units", "double_pendulum")
    assert message == (
        "double_pendulum.lag:17:11: error: unit mismatch: m1*g is a force [kg*m/s^2],"
        " potential needs an energy [J]\n"
        "   17 | potential m1*g + m2*g*y2\n"
        "      |           ^^^^\n"
        "   help: multiply by a height, e.g. m1*g*y1\n"
    )


def test_the_examples_of_the_manual():
    manual = ROOT / "docs" / "language.md"
    examples = re.findall(r"```lag\n(.*?)```", manual.read_text(encoding="utf-8"), re.DOTALL)
    assert len(examples) >= 2
    for example in examples:
        if "\ntable " not in example:  # Its data are beside it: tests/test_docs.py.
            model_of(example)


def test_places_of_names_stay():
    model = model_of(HEAD + "potential m*g*x\n")
    product = model.potential[0]
    assert [type(f) for f in product.factors] == [Name, Name, Name]
    start, end = product.factors[2].span.start, product.factors[2].span.end
    assert model.source.text[start:end] == "x"
    assert isinstance(model.parameters[0].default, Number)
