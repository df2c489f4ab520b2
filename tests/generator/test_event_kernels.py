"""Events and scenes as the language has them: what is understood, what becomes C."""

import random

import mpmath
import pytest
import sympy as sp
from c_harness import ROOT, Loaded, read_text

from conftest import case
from pkgen.compiler import check_model, compile_model
from pkgen.explain import explain
from pkgen.front.check import check
from pkgen.middle.derive import derive
from pkgen.scenes import model as scene_model
from pkgen.scenes import scene
from pkgen.source import ModelError, Source
from pkgen.system.exits import UsageError

CART = case("event_kernels_cart")


def sympy_events() -> tuple[list[sp.Symbol], list[sp.Expr]]:
    """The four functions, from the Lagrangian written out by hand."""
    _x, th, xd, thd, push, t = symbols = sp.symbols("x th xd thd push t", real=True)
    M, m, length, g = map(sp.Rational, ("1.7", "0.6", "0.9", "9.81"))
    T = M / 2 * xd**2 + m / 2 * (xd**2 + 2 * length * sp.cos(th) * xd * thd + length**2 * thd**2)
    V = -m * g * length * sp.cos(th)
    p_x, p_th = sp.diff(T, xd), sp.diff(T, thd)
    return list(symbols), [
        th,
        length * sp.sin(th) * thd + sp.Rational("0.3") * t,
        T + V - T * push - 2 * V,
        p_th * xd / length + p_x * length * sp.sin(th),
    ]


def test_the_kernel_is_what_sympy_says(tmp_path):
    equations, program = read_text(CART, "cart.lag")
    loaded = Loaded(program, tmp_path)
    symbols, wanted = sympy_events()
    functions = [sp.lambdify(symbols, f, "mpmath") for f in wanted]
    rng = random.Random(2385)
    for _ in range(10):
        q, v = ([rng.uniform(-2, 2) for _ in range(2)] for _ in "qv")
        push, t = rng.uniform(-2, 2), rng.uniform(0, 3)
        _, (got,) = loaded.call("event", t, q, v, [push])
        with mpmath.workdps(30):
            exact = [f(*q, *v, push, t) for f in functions]
        assert got == pytest.approx([float(x) for x in exact], rel=1e-12, abs=1e-12)
        assert all(abs(x) > 1e-6 for x in got)
    assert [e.name for e in equations.event_names] == ["right", "high", "rich", "firm"]


def test_directions_stops_units_and_descriptions():
    model, warnings = check.check_text(Source("cart.lag", CART))
    assert [(e.name, e.direction, e.stop) for e in model.events] == [
        ("right", 1, False),
        ("high", -1, True),
        ("rich", 0, False),
        ("firm", 0, False),
    ]
    assert [e.unit for e in model.events] == ["", "m/s", "J", "J"]
    assert model.events[1].description == "the bob turns"
    assert not warnings


def test_explain_shows_them():
    compilation = compile_model(Source("cart.lag", CART))
    text = explain.explain(compilation)
    assert "  right: theta rising\n" in text
    assert "[m/s] falling stop\n" in text
    records = explain.record(compilation)["events"]
    assert [r["direction"] for r in records] == ["rising", "falling", "either", "either"]


def test_the_table_for_the_runtime():
    files = compile_model(Source("cart.lag", CART)).files
    assert '{{"high", "m/s", "the bob turns"}, -1, 1}' in files["cart.c"]
    assert "{.n = 4, .table = cart_events, .values = cart_sys_event}" in files["cart_system.c"]
    assert "cart_e_high = 1" in files["cart.h"] and "cart_EVENTS = 4" in files["cart.h"]


def test_an_event_that_is_constant_by_an_identity_is_refused():
    text = "model m\ncoord x\nkinetic x'^2/2\nevent never: x - x + 1 rising\n"
    with pytest.raises(ModelError) as error:
        check_model(Source("m.lag", text))
    assert "m.lag:4:14: error: the event 'never' never happens" in error.value.text()


def test_a_chain_with_an_event_stays_a_loop():
    text = (ROOT / "models/chains/fput.lag").read_text()
    plain = compile_model(Source("fput.lag", text))
    with_event = compile_model(Source("fput.lag", text + "event mid: q[3] rising stop\n"))
    assert not plain.equations.dense and not with_event.equations.dense
    assert "fput_event(" in with_event.files["fput.c"]
    assert "fput_event" not in plain.files["fput.c"]
    assert '{{"mid", "", ""}, 1, 1}' in with_event.files["fput.c"]


# -- scenes --------------------------------------------------------------------------------------

SCENES = (
    CART
    + """
scene one  # as it is used
  set M = 2*m, m = 800 [g], push = -3
  start x = l/4, theta' = 2
  until 4*sqrt(l/g)
  method gauss4 step 1/100
  record theta, x', T, p_x, reach, Y, energy every 20*(1/1000 [s]) at right
end
scene two
  set push = (2 [N])*sin(t/(1 [s]))
  hold x
end
"""
)


def model_with(text: str = SCENES):
    return check.check_text(Source("cart.lag", text))[0]


def test_what_a_scene_says():
    one, two = model_with().scenes
    assert (one.name, one.description, one.method) == ("one", "as it is used", "gauss4")
    columns = [c.name for c in one.record.columns]
    assert columns == ["theta", "x'", "T", "p_x", "reach", "Y", "energy"]
    assert one.record.at == "right"
    assert [h.name for h in two.holds] == ["x"] and two.assignments[0].varies


def test_its_numbers_follow_what_the_command_line_sets():
    model = model_with()
    one = scene.chosen(model, "one")
    found = scene.numbers(model, one, {})
    # In the order written: M = 2 m is set before m is.
    assert found.parameters == {("M", None): 1.2, ("m", None): 0.8}
    assert found.inputs == {"push": -3.0}
    assert found.until == pytest.approx(4 * (0.9 / 9.81) ** 0.5, rel=1e-15)
    assert (found.step, found.rtol, found.every) == (0.01, None, 0.02)
    found = scene.numbers(model, one, {("m", None): 3.0, ("l", None): 1.8})
    assert found.parameters == {("M", None): 6.0}
    assert found.until == pytest.approx(4 * (1.8 / 9.81) ** 0.5, rel=1e-15)


def test_what_is_compiled_for_it():
    model = model_with()
    one = scene.chosen(model, "one")
    used = scene_model.used(model, one)
    assert [o.name for o in used.observed] == ["reach", "T", "p_x", "Y"]
    assert [o.unit for o in used.observed] == ["m", "J", "kg*m/s", "m"]
    assert scene_model.columns(one) == ["theta", "x'", "T", "p_x", "reach", "Y", "energy"]
    assert [s.name for s in used.starts] == ["x", "theta"]


@pytest.mark.parametrize(
    ("clause", "said"),
    [
        ("until m*(1 [s/kg]) - (0.6 [s])", "until: must be positive"),
        ("until (1 [kg*s])/(m - (0.6 [kg]))", "until: division by zero"),
    ],
)
def test_numbers_that_an_option_makes_wrong_have_their_place(clause, said):
    model = model_with(CART.replace("m = 0.6", "m = 1") + f"scene one\n  {clause}\nend\n")
    line = CART.count("\n") + 2
    one = scene.chosen(model, "one")
    assert scene.numbers(model, one, {("m", None): 0.7}).until > 0
    with pytest.raises(UsageError) as error:
        scene.numbers(model, one, {("m", None): 0.6})
    assert f"cart.lag:{line}:" in str(error.value) and said in str(error.value)


def test_an_input_driven_by_a_scene_is_a_definition_with_its_rate():
    text = case("event_kernels_m")
    model = model_with(text)
    one = scene.chosen(model, "one")
    used = scene_model.used(model, one)
    assert not used.inputs
    assert [d.name for d in used.definitions] == ["w0", "w", "u", "place"]
    equations = derive.derive(used)
    assert equations.inputs == ()
    # M = 1, f = -u'' = 180 sin(6 t); the plain model asks for u, u', u''.
    assert len(derive.derive(model).inputs) == 3
    assert scene_model.used(model, one, {"u"}).inputs == model.inputs


def test_a_scene_sets_members_of_families():
    text = case("event_kernels_m2")
    model = check.check_text(Source("m.lag", text))[0]
    found = scene.numbers(model, model.scenes[0], {("k", 3): 1.0})
    assert found.parameters == {("k", 1): 7.0, ("k", 2): 20.0}
    assert found.until == 28.0


def test_times_of_a_model_without_units():
    text = "model m\ncoord x\nkinetic x'^2/2\nscene a\n  until {}\n  record x every 0.5\nend\n"
    for until in ("3", "3 [s]", "3000 [ms]"):
        model = check.check_text(Source("m.lag", text.format(until)))[0]
        assert scene.numbers(model, model.scenes[0], {}).until == 3
    with pytest.raises(ModelError):
        check.check_text(Source("m.lag", text.format("3 [m]")))
