"""Reduced equations against the whole ones, at states where nothing is special."""

import math
import random

import pytest
import sympy

from conftest import case
from pkgen.front import parse
from pkgen.front.check import check
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.analyze.analyze import analyze
from pkgen.middle.derive.derive import derive
from pkgen.middle.reduce.apart import parts_of
from pkgen.middle.reduce.cyclic import cyclic
from pkgen.middle.reduce.reduce import reduce
from pkgen.middle.reduce.reduction import ENOUGH, Needs, State
from pkgen.middle.report import Report
from pkgen.middle.specialise import folded, held
from pkgen.scenes.compile_plan import _without_mass
from pkgen.source import ModelError, Source

TOP = case("reduce_top")
CART = case("reduce_cart")
MAGNETIC = case("reduce_magnetic")
TURNING = case("reduce_turning")
PAIR = case("reduce_pair")


def equations_of(text: str):
    model, _ = check.check(parse.parse_all(Source("a.lag", text)), {})
    return derive(model, ENOUGH)


def reduced(equations, *columns: str, **more):
    needs = Needs(frozenset(columns), **more)
    return reduce(equations, analyze(equations), needs, ENOUGH)


def somewhere(equations, seed: int) -> dict[Symbol, float]:
    """Values of all symbols; of parameters their defaults, so that momenta are those of the start
    where the state is it."""
    draw = random.Random(seed)
    n = len(equations.coordinates)
    values = {
        Symbol(kind, i): draw.uniform(0.4, 1.6)
        for kind in (Kind.COORDINATE, Kind.RATE)
        for i in range(n)
    }
    return values | {Symbol(Kind.TIME): 0.0}


def parameters(equations, values: dict) -> dict[Symbol, float]:
    found: dict[Symbol, float] = {}
    for i, slot in enumerate(equations.parameters):
        (found[Symbol(Kind.PARAMETER, i)],) = evaluate(
            equations.graph, [slot.default], {**values, **found}
        )
    return found


def renumbered(values: dict, kept: list[int]) -> dict:
    return {
        Symbol(kind, new): values[Symbol(kind, old)]
        for kind in (Kind.COORDINATE, Kind.RATE)
        for new, old in enumerate(kept)
    }


@pytest.mark.parametrize(
    ("text", "kept", "angle"),
    [
        (TOP, ["theta"], "phi"),
        (CART, ["theta"], "x"),
        (MAGNETIC, ["y", "s"], "x"),
        (TURNING, ["r", "z"], "phi"),
    ],
)
def test_a_motion_without_its_cyclic_coordinates_is_the_same(text, kept, angle):
    whole = equations_of(text)
    names = [q.name for q in whole.coordinates]
    found = reduced(whole, *kept, angle, f"{angle}'")
    small = found.equations
    assert [q.name for q in small.coordinates] == kept
    assert [q.name for q in small.states] == [angle]
    for seed in range(4):
        state = somewhere(whole, seed)
        given = parameters(whole, state)
        accelerations = evaluate(whole.graph, whole.acceleration, state | given)
        # The momenta are those of this very state, made the start.
        known = {**state, **given}
        del known[Symbol(Kind.TIME)]  # the momenta are those at t = 0
        for (name, order), parameter in found.report.starts.items():
            kind = Kind.RATE if order else Kind.COORDINATE
            place = [s.quantity.name for s in small.parameters].index(parameter)
            known[Symbol(Kind.PARAMETER, place)] = state[Symbol(kind, names.index(name))]
        for i, slot in enumerate(small.parameters):
            if Symbol(Kind.PARAMETER, i) not in known:
                (known[Symbol(Kind.PARAMETER, i)],) = evaluate(small.graph, [slot.default], known)
        known |= {Symbol(Kind.TIME): 0.0}
        known |= renumbered(state, [names.index(name) for name in kept])
        again = evaluate(small.graph, small.acceleration, known)
        for name, value in zip(kept, again, strict=True):
            assert value == pytest.approx(accelerations[names.index(name)], rel=1e-11, abs=1e-12)
        rate = state[Symbol(Kind.RATE, names.index(angle))]
        assert abs(rate) > 0.1
        nodes = [*small.state_rates, small.observed[-1], small.energy]
        *rates, energy = evaluate(small.graph, nodes, known)
        assert rates == pytest.approx([rate, rate], rel=1e-11)
        assert energy == pytest.approx(*evaluate(whole.graph, [whole.energy], state | given))


def test_what_a_cyclic_coordinate_is_needed_for_keeps_it():
    whole = equations_of(TURNING.replace("0.2*phi'", "0.2*sin(phi)"))
    found = reduced(whole, "r", "z")
    assert len(found.equations.coordinates) == 3
    assert "phi kept: it is in a force" in [str(line) for line in found.report.lines]
    text = "model m\ncoord x, y\nkinetic (x'^2 + y'^2)/2\nlagrangian y*x' - y^4\n"
    text += "dissipation y'^2\nstart y = 1\n"
    whole = equations_of(text)
    assert len(reduced(whole, "y", "x").equations.coordinates) == 1
    found = reduced(whole, "y", "x", facts=("affine_rates",))  # boris
    assert len(found.equations.coordinates) == 2
    assert "x kept: the method requires affine_rates" in map(str, found.report.lines)
    whole = equations_of(TOP)
    # In whatever order, and each can be switched off.
    found = reduced(whole, "theta", off=frozenset({"cyclic"}))
    assert len(found.equations.coordinates) == 3
    free = equations_of("model loose\ncoord x, y\nkinetic x'^2 + y'^2\n")
    assert len(reduced(free, "x'", off=frozenset({"apart"})).equations.coordinates) == 1


def test_coordinates_without_influence_go_and_no_others():
    whole = equations_of(PAIR)
    for columns, kept in ((["a"], "ac"), (["c'"], "ac"), (["b"], "abc"), (["energy", "a"], "abc")):
        small = reduced(whole, *columns).equations
        assert "".join(q.name for q in small.coordinates) == kept
    assert len(reduced(whole, "gap").equations.coordinates) == 3
    small = reduced(whole, "a").equations
    assert small.observed_names == ()
    for seed in range(3):
        state = somewhere(whole, seed)
        known = state | parameters(whole, state)
        one = evaluate(whole.graph, whole.acceleration, known)
        known |= renumbered(state, [0, 2])
        assert evaluate(small.graph, small.acceleration, known) == pytest.approx(
            [one[0], one[2]], rel=1e-13
        )


def test_blocks_apart_move_as_in_the_whole():
    whole = equations_of(PAIR.replace("force b = 0.1*a\n", ""))
    parts = parts_of(whole, analyze(whole), ENOUGH)
    assert [part.coordinates for part in parts] == [(0, 2), (1,)]
    for part in parts:
        state = somewhere(whole, 7)
        known = state | parameters(whole, state)
        one = evaluate(whole.graph, whole.acceleration, known)
        known |= renumbered(state, list(part.coordinates))
        found = evaluate(part.equations.graph, part.equations.acceleration, known)
        assert found == pytest.approx([one[i] for i in part.coordinates], rel=1e-13)
    whole = equations_of(PAIR)
    assert parts_of(whole, analyze(whole), ENOUGH) == ()


@pytest.mark.parametrize(
    "terms", ["potential x^2 + z^2", "force x = cos(t)", "potential x^2\nforce y = z*cos(t)"]
)
def test_inertia_that_is_shared_counts_where_no_acceleration_depends_on_the_coordinate(terms):
    """x'' = F/(M_xx - M_xy^2/M_yy), which has nothing of y in it and is not F/M_xx."""
    whole = equations_of(
        f"model inert\ncoord x, y, z\nkinetic x'^2 + y'^2 + z'^2 + x'*y'\n{terms}\n"
    )
    state = somewhere(whole, 11)
    one = evaluate(whole.graph, whole.acceleration, state)
    found = [reduced(whole, "x", off=frozenset({"cyclic"})).equations]
    found += [part.equations for part in parts_of(whole, analyze(whole), ENOUGH)]
    for part in found:
        names = [q.name for q in part.coordinates]
        assert ("x" in names) <= ("y" in names)
        kept = ["xyz".index(name) for name in names]
        known = state | renumbered(state, kept)
        alone = evaluate(part.graph, part.acceleration, known)
        assert alone == pytest.approx([one[i] for i in kept], rel=1e-13)


def scene_of(text: str, clauses: str):
    text += "scene one\n" + "".join(f"  {line}\n" for line in clauses.split("\n")) + "end\n"
    model, _ = check.check(parse.parse_all(Source("a.lag", text)), {})
    return model, model.scenes[0]


def test_fixed_parameters_are_numbers():
    text = PAIR.replace("param k = 2.3", "param h = 2\nparam k = 3*h\nconst c0 = 1.5")
    model, scene = scene_of(text, "set h = c0 + 1, k = 2*h")
    model, lines = folded(model, scene, frozenset())
    e = derive(model, ENOUGH)
    assert e.parameters == () and len(lines) == 1
    state = somewhere(e, 3)
    found = evaluate(e.graph, e.acceleration, state)
    whole = equations_of(text)
    given = {Symbol(Kind.PARAMETER, 0): 2.5, Symbol(Kind.PARAMETER, 1): 5.0}
    assert found == pytest.approx(evaluate(whole.graph, whole.acceleration, state | given))
    # A value from before what is set after it, and what the run sets, stay parameters.
    model, scene = scene_of(text, "set k = 2*h, h = 7")
    assert [p.name for p in folded(model, scene, frozenset())[0].parameters] == ["k"]
    assert [p.name for p in folded(model, scene, frozenset({"h"}))[0].parameters] == ["h", "k"]


@pytest.mark.parametrize(("name", "motion"), [("theta", "0.4 + 0.3*sin(2*t)"), ("x", "t^2*0.2")])
def test_what_is_held_drives_the_rest(name, motion):
    """M_rr a_r + M_rh g'' = f_r, with q_h = g(t) put in."""
    whole = equations_of(CART)
    names = [q.name for q in whole.coordinates]
    model, scene = scene_of(CART, f"hold {name} = {motion}")
    model, lines = held(model, scene)
    e = derive(model, ENOUGH)
    h, r = names.index(name), 1 - names.index(name)
    assert [q.name for q in e.coordinates] == [names[r]] and len(lines) == 1
    t = sympy.Symbol("t")
    g = sympy.sympify(motion.replace("^", "**"), {"t": t})
    at = 0.83
    state = somewhere(whole, 5)
    state |= {Symbol(Kind.TIME): at}
    state |= {Symbol(Kind.COORDINATE, h): float(g.subs(t, at))}
    state |= {Symbol(Kind.RATE, h): float(g.diff(t).subs(t, at))}
    known = state | parameters(whole, state)
    m_rr, m_rh, f = evaluate(
        whole.graph, [whole.mass[r][r], whole.mass[r][h], whole.force[r]], known
    )
    expected = (f - m_rh * float(g.diff(t, 2).subs(t, at))) / m_rr
    known = parameters(e, state) | state | renumbered(state, [r])
    assert evaluate(e.graph, e.acceleration, known) == pytest.approx([expected], rel=1e-12)


def test_ends_of_families_are_held_and_nothing_inside():
    chain = case("reduce_chain")
    model, scene = scene_of(chain, "hold q[1] = sin(t)\nhold q[4] = cos(t)")
    e = derive(held(model, scene)[0], ENOUGH)
    assert [q.name for q in e.coordinates] == ["q[2]", "q[3]"]
    state = {Symbol(Kind.COORDINATE, 0): 0.3, Symbol(Kind.COORDINATE, 1): 0.5}
    state |= {Symbol(Kind.RATE, 0): 0.0, Symbol(Kind.RATE, 1): 0.0, Symbol(Kind.TIME): 0.9}
    assert evaluate(e.graph, e.acceleration, state) == pytest.approx(
        [math.sin(0.9) - 2 * 0.3 + 0.5, 0.3 - 2 * 0.5 + math.cos(0.9)]
    )
    assert evaluate(e.graph, e.start_q, {}) == pytest.approx([0.2, 0.3])
    model, scene = scene_of(chain, "hold q[2] = sin(t)")
    with pytest.raises(ModelError) as error:
        held(model, scene)
    assert "neither the first nor the last" in error.value.text()
    model, scene = scene_of(chain.replace("free q", "periodic q"), "hold q[1] = sin(t)")
    with pytest.raises(ModelError) as error:
        held(model, scene)
    assert "periodic" in error.value.text()


def test_of_many_bodies_no_cyclic_coordinate_goes():
    """What is left of M would be dense, and not solved along the tree."""
    text = "model arm\n"
    for k in range(24):
        axis = "[0, 1, 0]" if k % 2 else "[0, 0, 1]"
        parent, at = (f"b{k - 1}", " at [0, 0, 0.3]") if k else ("ground", "")
        text += f"body b{k} mass 1 inertia [0.1, 0.2, 0.3] at [0, 0, 0.2]\n"
        text += f"joint q{k}: {parent} to b{k} revolute {axis}{at}\n"
    model, _ = check.check(parse.parse_all(Source("arm.lag", text)), {})
    e = derive(model, ENOUGH)
    structure = analyze(e)
    assert structure.cyclic[0] and e.acceleration
    state = cyclic(State(e, structure, Report()), Needs(frozenset()))
    (line,) = state.report.lines
    assert line.why == "what is left would couple too many coordinates"
    assert _without_mass(e)
    small = derive(check.check(parse.parse_all(Source("cart.lag", CART)), {})[0], ENOUGH)
    assert not _without_mass(small)
