"""`conserve`: proved, refuted and not proved, each where it is so; SymPy has a second opinion."""

import subprocess
import sys
from itertools import islice

import pytest
import sympy
from claims import KEPLER, LENZ, LINKS, PAIR, PENDULUM, POLAR, claims, outcomes

from conftest import ROOT
from pkgen.compiler import check_model, stages
from pkgen.middle.analyze.along import Along
from pkgen.middle.analyze.sympy_bridge import to_sympy
from pkgen.source import ModelError, Source


@pytest.mark.parametrize(
    ("model", "claim"),
    [
        (KEPLER, "conserve J = Lx^2 + Ly^2 + Lz^2 + energy"),
        (POLAR, "conserve Ax = L*(r'*sin(phi) + r*phi'*cos(phi)) - mu*cos(phi)"),
        (POLAR, "conserve e2 = (L^2/r - mu)^2 + (L*r')^2"),
        (PENDULUM, "conserve h = a'^2/2 + 2*g*sin(a/2)^2"),  # half angles
        (PENDULUM, "conserve h = exp(energy)*sinh(energy)/cosh(energy)^3"),
        (LINKS, "conserve P = p_a + p_b"),
        (LINKS, "conserve J = m*a' + x*y' - y*x'"),
        (LINKS, "conserve J = ((2 - m)*sin(a)^2 + p_a + p_b + (2 - m)*cos(a)^2)^3"),
        (LINKS, "conserve h = (1 + m)/2*a'^2 + b'^2/2 + a'*b'*cos(a - b)"),
        (PAIR, "conserve c = x*y' - y*x'"),
        (PAIR, "conserve c = x - t*x'"),
        (PAIR + "potential x*y\n", "conserve c = (x' + y')^2 + (x + y)^2"),
        (PAIR + "potential (x^2)^(2/3)\n", "conserve c = x'^2/2 + x^2/(x^2)^(1/3)"),
        (PAIR + "param n = 3\npotential x^(2*n)/n\n", "conserve c = (x'^2*n/2 + x*x^(2*n - 1))/n"),
        (PAIR + "potential log(cosh(x))\n", "conserve c = x'^2/2 + log(exp(x) + exp(-x))"),
        (PAIR + "force x = sin(t)\n", "conserve c = x' + cos(t)"),
        (PAIR + "dissipation x'^2/2\n", "conserve c = x' + x"),
        (PAIR + "dissipation x'^2/2\n", "conserve c = x'*exp(t)"),
        (PAIR + "input u\npotential u*x\n", "conserve c = y'"),
        (PAIR + "input u\nkinetic (x' + u)^2/2\n", "conserve c = x' + u/2"),  # u' cancels
        (PAIR, "conserve c = max(x, -x) + min(x*y, -x*y) - abs(x)*(1 - abs(y))"),
        (PAIR, "conserve c = max(x + y, -x - y) - abs(-3*x - 3*y)/3"),
        (PAIR, "conserve c = max(x, y) + max(-x, -y) - abs(x - y)"),
        (PAIR + "potential abs(x)\n", "conserve c = x'^2 + 2*max(x, -x)"),
        (
            PAIR + "param k = 2 in (0, inf)\npotential abs(k*x)\n",
            "conserve c = x'^2/2 + k*abs(x)",
        ),
        # Divided by what the motion ends at.
        (POLAR, "conserve c = (abs(L)/r)^2*r + sqrt(r^2)/r - L^2/r"),
        (
            POLAR + "param m = 2\nkinetic m/2*r^2*phi'^2\nforce phi = 1/3\n",
            "conserve c = (3*p_phi - t)^2",
        ),
        *(
            (PENDULUM, f"conserve c = energy + {identity}")
            for identity in (
                "sin(a + pi/2) - cos(a)",
                "sin(a - 3*pi/2)*sin(a + pi) + cos(a)*sin(a)",
                "cos(a + 5*pi/6) - cos(a)*cos(5*pi/6) + sin(a)*sin(5*pi/6)",
                "cos(3*a + 1/2) - 4*cos(a + 1/6)^3 + 3*cos(a + 1/6)",
                "cos(5*pi/3)*a - (2*cos(5*pi/6)^2 - 1)*a",
                "tan(a)^2 - 1/cos(a)^2",
                "cosh(a)^2 - sinh(a)^2 - exp(a)*exp(-a) + tanh(2*a)*cosh(2*a)/sinh(2*a)",
            )
        ),
    ],
)
def test_proved(model, claim):
    assert outcomes(f"{model}{claim}\n") == ["proved"]


def test_the_vector_of_laplace_runge_and_lenz():
    assert outcomes(KEPLER + LENZ) == ["proved"] * 3
    for perturbed in ("-mu/r + eps/r^3", "-mu/r^(1 + eps)"):
        assert outcomes(KEPLER.replace("-mu/r", perturbed) + LENZ) == ["refuted"] * 3


@pytest.mark.parametrize(
    ("model", "claim"),
    [
        (KEPLER, "conserve c = Lx*x + Lz"),
        (KEPLER, "conserve c = energy + 1e-30*x"),  # far below the rounding of a double
        (PENDULUM, "conserve c = a'^2/2 + g*cos(a)"),
        (PENDULUM, "conserve c = energy + u"),
        (PENDULUM, "conserve c = energy + cos(5*pi/6)*a"),
        (PENDULUM.replace("-g*cos(a)", "-g*cos(a)*(1 + u)"), "conserve c = energy"),
        (PENDULUM.replace("-g*cos(a)", "-g*cos(a - t)"), "conserve c = energy"),
        (PENDULUM + "dissipation a'^2/100\n", "conserve c = energy"),
        (LINKS + "potential y\n", "conserve P = p_a + p_b"),
        (PAIR + "potential x\n", "conserve c = x*y' - y*x'"),
        (PAIR, "conserve c = max(x, -x)"),
        (PAIR, "conserve c = max(x, 2*x) - abs(x)"),
        (PAIR, "conserve c = max(x - 20, 0)"),  # 0 anywhere near the start
        (PAIR + "param k = -2\npotential abs(k*x)\n", "conserve c = x'^2/2 + k*abs(x)"),
    ],
)
def test_refuted(model, claim):
    assert outcomes(f"{model}{claim}\n") == ["refuted"]


def test_a_counterexample_is_one():
    """Its numbers, put into SymPy's derivative along x'' = -x^2 - 1/10, are those that it says."""
    text = PAIR + "param b = 0.1\npotential x^3/3 + b*x\nconserve c = x*x'\n"
    (claim,) = claims(text)
    said = dict(pair.split(" = ") for pair in claim.says.split("at ")[1].split(", "))
    rate = claim.says.split(" = ")[1].split(",")[0]
    x, v = sympy.Rational(said["x"]), sympy.Rational(said["x'"])
    assert float(v**2 + x * (-(x**2) - sympy.Rational(1, 10))) == pytest.approx(
        float(rate), rel=1e-3
    )


def test_a_counterexample_is_where_numbers_can_be_seen():
    """Next to nothing but near 7; and next to nothing anywhere, refuted all the same."""
    (claim,) = claims(PAIR + "conserve c = exp(-1000*(x - 7)^2)\n")
    assert claim.outcome == "refuted" and "at x = 6.8" in claim.says
    (claim,) = claims(PAIR + "conserve c = exp(-1e6*(x^2 + 7))\n")
    assert claim.outcome == "refuted" and "e-30" in claim.says


def test_of_parameters_too():
    """True for the default alone."""
    text = PAIR + "param k = 1\npotential x^2/2 + k*y^2/2\nconserve c = x*y' - y*x'\n"
    (claim,) = claims(text)
    assert claim.outcome == "refuted" and "k = " in claim.says and "const" in claim.says
    assert outcomes(text.replace("param", "const")) == ["proved"]


@pytest.mark.parametrize(
    ("model", "claim", "why"),
    [
        # True wherever the model is defined, but not everywhere where the claim is.
        (
            PAIR + "potential sqrt(x)*sqrt(y)\n",
            "(x'^2 + y'^2)/2 + sqrt(x*y)",
            "states tried",
        ),
        (PAIR, "step(x)", "step jumps"),
        (PAIR + "potential step(x)\n", "x'", "L jumps"),
        # d/dt is 0, yet phi grows by what atan2 falls back each turn.
        (
            "model m\ncoord r, phi\nkinetic (r'^2 + r^2*phi'^2)/2\nstart r = 1\n",
            "atan2(r*sin(phi), r*cos(phi)) - phi",
            "atan2 jumps",
        ),
        (PAIR, "abs(x)/x", "it may jump where x vanishes"),
        (PAIR, "atan(1/x) + atan(x)", "it may jump where x vanishes"),
        (PAIR, "atan(tan(x)) - x", "where cos(x) vanishes; dc/dt is 0 at"),
        (PAIR, "sqrt(-1 - x^2)", "no state"),
    ],
)
def test_neither(model, claim, why):
    (found,) = claims(f"{model}conserve c = {claim}\n")
    assert found.outcome == "not proved" and why in found.says


def test_what_is_not_proved_is_an_error():
    text = POLAR + "conserve a = r\nconserve b = r^2*phi'\nconserve c = r + sqrt(-1 - r^2)\n"
    with pytest.raises(ModelError) as raised:
        check_model(Source("x.lag", text))
    first, second = raised.value.diagnostics
    assert first.message.startswith("'a' is not constant: da/dt = ")
    assert second.message.startswith("that 'c' is constant is not proved: ")
    assert "observe a" in first.help and text[first.span.start :].startswith("conserve a")


def test_the_derivative_is_sympys():
    """Along the equations of two links, at exact arguments, against M solved by SymPy."""
    text = LINKS + "potential y\nobserve c = a'*x*sin(b) + t*b'^2*y\n"
    _, _, e, structure = islice(stages(Source("x.lag", text), {}), 4)
    along = Along(e, structure.mass_blocks)
    ours = along.graph.sum(along.terms(e.observed[0]))
    names = {}

    def symbol(s):
        return names.setdefault(s, sympy.Symbol(f"{s.kind}{s.index}"))

    ours, claim, *rest = to_sympy(
        along.graph, [ours, e.observed[0], *sum(e.mass, ()), *e.force], symbol
    )
    a = sympy.Matrix(2, 2, rest[:4]).LUsolve(sympy.Matrix(rest[4:]))
    by = {s.kind + str(s.index): x for s, x in names.items()}
    theirs = sum(
        (
            sympy.diff(claim, by[f"coordinate{i}"]) * by[f"rate{i}"]
            + sympy.diff(claim, by[f"rate{i}"]) * a[i]
            for i in range(2)
        ),
        sympy.diff(claim, by["time0"]),
    )
    at = {x: sympy.Float(0.1 + k * 0.37, 40) for k, x in enumerate(names.values())}
    assert ours.subs(at).evalf(30) == pytest.approx(theirs.subs(at).evalf(30), rel=1e-25)
    assert abs(theirs.subs(at).evalf(30)) > 0.01


def test_sympy_is_not_imported_without_need():
    """The second model has a claim, but one that is proved without it."""
    program = (
        "import sys; from pkgen.__main__ import main; "
        "codes = [main(['check', path]) for path in sys.argv[1:]]; "
        "sys.exit(any(codes) or 5 * bool({'sympy', 'mpmath'} & set(sys.modules)))"
    )
    models = [ROOT / f"models/{name}.lag" for name in ("double_pendulum", "heavy_top")]
    subprocess.run([sys.executable, "-c", program, *models], check=True)
