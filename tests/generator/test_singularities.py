"""Where the equations end: which expressions are singularities, of which kind and name."""

import math
import random

import pytest
from building import model
from c_harness import MODELS, Loaded, read_model, read_text

from pkgen.functions import FUNCTIONS
from pkgen.functions.interval import ANY, Range
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Graph, Kind, Symbol
from pkgen.graph.ranges import Ranges
from pkgen.graph.wording import wording
from pkgen.middle.derive.derive import derive

CHART, MOTION = True, False
OF_MODELS = {
    "bead_on_hoop": [],
    "coupled_oscillators": [],
    "double_pendulum": [],
    "elastic_pendulum": [("l0 + s", CHART)],
    "heavy_top": [("sin(theta)", CHART)],
    "two_pendulums": [],
}


def singularities(equations) -> list[tuple[str, bool]]:
    return [
        (singularity.quantity.name, singularity.use == "COORDINATES")
        for singularity in equations.singularities
    ]


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_singularities_of_the_models(path):
    assert singularities(read_model(path)[0]) == OF_MODELS[path.stem]


def in_plane(potential: str, kinetic: str = "x'^2/2 + y'^2/2", more: str = "") -> str:
    parameters = "param k = 2 in (0, inf)\nparam e = 0.1 in [0, 1)\nparam l = 1\n"
    parameters += "param d = 1 in [0, inf)\n"
    return f"model m\n{parameters}coord x, y\nkinetic {kinetic}\npotential {potential}\n{more}"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # Divisions, roots and logarithms of what can vanish.
        (in_plane("-k/norm([x, y, 0])"), [("x^2 + y^2", MOTION)]),
        (in_plane("-k/x"), [("x", MOTION)]),
        (in_plane("-k/(x*y)"), [("x", MOTION), ("y", MOTION)]),
        (in_plane("-k*log(x - l)"), [("x - l", MOTION)]),
        (in_plane("k*sqrt(x - l)"), [("x - l", MOTION)]),
        (in_plane("k*x^1.5"), [("x", MOTION)]),
        (in_plane("k*tan(x)"), [("cos(x)", MOTION)]),
        (in_plane("k*asin(x)"), [("1 - x^2", MOTION)]),
        # What is proved never to vanish, or vanishes without harm.
        (in_plane("-k/sqrt(x^2 + y^2 + k^2)"), []),
        (in_plane("-1/(1 + e*cos(x)) + exp(x)/cosh(y)"), []),
        (in_plane("log(2 + sin(x)) + (k + x^2)^2.5 + x^3"), []),
        (in_plane("x", more="dissipation 0.1*norm([x', y', 0])^3\n"), []),
        (in_plane("abs(x) + max(x, y)"), []),
        # The chart: M is singular there.
        (in_plane("x", "x'^2/2 + x^2*y'^2/2"), [("x", CHART)]),
        (in_plane("-k/x", "x'^2/2 + x^2*y'^2/2"), [("x", CHART)]),
        (in_plane("x", "k*(l - x)*x'^2/2 + y'^2/2"), [("l - x", CHART)]),
        (in_plane("x", "(x^2 + y^2)*(x'^2 + y'^2)/2"), [("x^2 + y^2", CHART)]),
        # Pivots that are sums: k + sin^2 stays; 1 - 4 cos^2 does not.
        (in_plane("x", "(1 + k)*x'^2/2 + y'^2/2 + x'*y'*cos(x - y)"), []),
        (in_plane("x", "x'^2/2 + y'^2/2 + 2*x'*y'*cos(x)"), None),
        # Definite by default, but not for every value that the parameters may have.
        (in_plane("x", "x'^2/2 + y'^2/2 + l/2*x'*y'*cos(x)"), [("1 - 1/4*l^2*cos(x)^2", CHART)]),
        (in_plane("x", "x'^2/2 + y'^2/2 + e*x'*y'*cos(x)"), []),
        (
            in_plane("x", "(d + 1)*x'^2/2 + y'^2/2 + x'*y'*cos(x)"),
            [("1 + d - cos(x)^2", CHART)],
        ),
        (in_plane("x", "(k + 1)*x'^2/2 + y'^2/2 + x'*y'*cos(x)"), []),
    ],
)
def test_singularities_of_equations(text, expected):
    equations, _ = read_text(text)
    found = singularities(equations)
    if expected is None:  # some form of 1 - 4 cos(x)^2
        ((_, chart),) = found
        assert chart and _value(equations, math.acos(0.5)) == pytest.approx(0, abs=1e-12)
        assert abs(_value(equations, 0.7)) > 0.1
    else:
        assert found == expected


def _value(equations, x: float) -> float:
    values = {Symbol(Kind.COORDINATE, i): x for i in range(2)}
    return evaluate(equations.graph, [equations.singularities[0].node], values)[0]


def test_only_where_asked_for():
    kepler = model(coords=("x",), kinetic="x'^2/2", potential="-1/x")
    assert len(derive(kepler).singularities) == 1
    assert len(derive(kepler, frozenset({"singularity"})).singularities) == 1
    assert derive(kepler, frozenset({"mass"})).singularities == ()


def test_the_kernel_and_its_table(tmp_path):
    _, program = read_model(next(p for p in MODELS if p.stem == "heavy_top"))
    loaded = Loaded(program, tmp_path)
    assert loaded.call("singularity", 0, [0.3, 2.385, 0.1], [0, 0, 0])[1] == [[math.sin(2.385)]]
    source = (tmp_path / "heavy_top_system.c").read_text()
    assert '{{"sin(theta)", "", ""}, PK_SINGULARITY_COORDINATES},' in source
    table = source[source.index(".singularities = {") :].split("}")[0]
    assert ".n = 1," in table and ".values = heavy_top_sys_singularity" in table


ALONE = [name for name, row in FUNCTIONS.items() if len(row.arguments) == 1]


def test_ranges_hold_what_is_evaluated():
    """Random expressions at random values; and a few ranges that are known."""
    g = Graph()
    x, p = g.symbol(Symbol(Kind.COORDINATE, 0)), g.symbol(Symbol(Kind.PARAMETER, 0))
    ranges = Ranges(g, [Range(0, 3, above=True)])
    draw = random.Random(2385)
    nodes = [x, p, g.number(2), g.negate(p)]
    for _ in range(300):
        a, b = draw.choice(nodes), draw.choice(nodes)
        kind = draw.randrange(4)
        if kind == 0:
            nodes.append(g.add(a, b))
        elif kind == 1:
            nodes.append(g.multiply(a, b))
        elif kind == 2:
            nodes.append(g.call(draw.choice(ALONE), a))
        else:
            nodes.append(g.power(a, draw.choice([2, 3, -1, -2])))
    proved = 0
    for _ in range(40):
        values = {Symbol(Kind.COORDINATE): draw.uniform(-4, 4)}
        values[Symbol(Kind.PARAMETER)] = draw.uniform(1e-3, 3)
        for node, value in zip(nodes, evaluate(g, nodes, values), strict=True):
            if math.isfinite(value):
                found = ranges(node)
                slack = 1e-9 * abs(value)
                assert found.lo - slack <= value <= found.hi + slack
                proved += found != ANY
    assert proved > 1000
    square, unit = g.power(x, 2), g.call("cos", x)
    assert ranges(g.add(square, p)).positive and not ranges(square).never_zero
    assert ranges(g.add(g.number(2), unit)).positive
    assert not ranges(g.add(g.number(1), unit)).positive
    assert ranges(g.negate(g.call("exp", x))).never_zero
    assert not ranges(g.multiply(square, g.call("exp", g.add(x, p)))).never_zero


@pytest.mark.parametrize(
    "text", ["x", "x^2", "x - y", "2*x + y", "sin(x)", "(x - y)^2 + 1", "-x*y", "x^(3/2)", "1/x"]
)
def test_wording_reads_as_written(text):
    name = {0: "x", 1: "y"}.get
    equations, _ = read_text(in_plane("x", more=f"observe o = {text}\n"))
    g, (node,) = equations.graph, equations.observed
    worded = wording(g, node, lambda s: name(s.index))
    again, _ = read_text(in_plane("x", more=f"observe o = {worded}\n"))
    values = {Symbol(Kind.COORDINATE, 0): 0.7, Symbol(Kind.COORDINATE, 1): 1.9}
    values |= {Symbol(Kind.PARAMETER, i): 1.3 for i in range(3)}
    assert evaluate(again.graph, again.observed, values) == evaluate(g, [node], values)
    assert len(wording(g, g.power(g.sum([node] * 3), 7), lambda s: "long_name" * 9)) == 60


def test_a_wording_of_what_is_shared_takes_no_time():
    """Each node of the tower uses the one below it twice: as a tree it has 2^50 leaves."""
    g = Graph()
    node = g.symbol(Symbol(Kind.COORDINATE, 0))
    for _ in range(50):
        node = g.add(g.call("sin", node), g.call("cos", node))
    asked = 0

    def name(symbol: Symbol) -> str:
        nonlocal asked
        asked += 1
        return "x"

    assert wording(g, node, name).endswith("...") and asked < 10


def test_a_parameter_as_exponent_is_a_singularity_where_it_is_negative():
    equations, _ = read_text("model m\nparam n = 2\ncoord x\nkinetic x'^2/2\npotential x^n/2\n")
    ((singularity),) = equations.singularities
    assert singularity.quantity.name == "x"
    (n,) = (k for k, slot in enumerate(equations.parameters) if slot.quantity.name == "n")

    def value(exponent: float, x: float) -> float:
        at = {Symbol(Kind.PARAMETER, n): exponent, Symbol(Kind.COORDINATE, 0): x}
        (found,) = evaluate(equations.graph, [singularity.node], at)
        return found

    # The force has x^(n - 1).
    assert value(2, 0) == value(2, -0.3) == value(1, 0) == 1
    assert value(-1, 0) == 0 and value(-1, -0.3) == pytest.approx(0.09)


def test_a_power_of_a_parameter_that_divides():
    equations, _ = read_text("model m\nparam n = 2\ncoord x\nkinetic x'^2/2\npotential 1/x^n\n")
    assert {name for name, _ in singularities(equations)} == {"x"}

    def least(n: float, x: float) -> float:
        at = {Symbol(Kind.PARAMETER, 0): n, Symbol(Kind.COORDINATE, 0): x}
        return min(
            evaluate(
                equations.graph, [singularity.node for singularity in equations.singularities], at
            )
        )

    assert least(2, 0) == 0 and least(2, 0.1) > 0


@pytest.mark.parametrize(
    ("force", "at_zero"),  # the value of what is watched where y = 0, for x = -1 and x = 1
    [
        ("if(x > 0, 1/y, 0)", (1, 0)),
        ("if(x > 0, 1/y, 2/y)", (0, 0)),  # in both branches
        ("if(x > 0, 1/y, 0) + 1/y", (0, 0)),  # without a condition too
        ("if(x > 0 and t > 1, sqrt(y), 0)", (1, 1)),
        ("if(y > 0, sqrt(y), 0)", None),  # the condition bounds it
        ("if(y > 0 or x > 0, sqrt(y), 0)", (1, 0)),
    ],
)
def test_a_branch_of_an_if_counts_where_it_is_chosen(force, at_zero):
    e = read_text(in_plane("0*x", more=f"force x = {force}\n"))[0]
    found = [x.node for x in e.singularities if x.quantity.name.strip("abs()") == "y"]
    assert len(found) == (at_zero is not None)
    for x, wanted in zip((-1, 1), at_zero or (), strict=False):
        state = {Symbol(Kind.COORDINATE, 0): x, Symbol(Kind.COORDINATE, 1): 0.0}
        assert evaluate(e.graph, found, state | {Symbol(Kind.TIME): 0.5}) == [wanted]
