"""What people write from Modelica, SymPy, MATLAB, LaTeX and others: the line to write instead."""

import pytest

from pkgen.compiler import check_model
from pkgen.front.read import from_text
from pkgen.source import ModelError

HEAD = "model h\nparam k = 1\nparam m = 1\ncoord x\nkinetic m/2*x'^2\npotential k*x^2\n"
SAID = {
    "x'' = -k/m*x": "derives the motion",
    "m*x'' = -k*x": "derives the motion",
    "m*x.. = -k*x": "derives the motion",
    "ddot(x) = -k*x": "derives the motion",
    "equation x'' + x = 0": "derives the motion",
    "der(x) = v": "a rate is written x'",
    "dx/dt = v": "a rate is written x'",
    "x' = -k*x": "write 'state x' and 'rate x = …'",
    "d/dt x = 3": "a rate is written x'",
    "kinetic m/2*xdot^2": "written x'",
    "kinetic m/2*x_dot^2": "written x'",
    "kinetic m/2*diff(x, t)^2": "a rate is written x'",
    "kinetic m/2*der(x)^2": "a rate is written x'",
    "kinetic 1/2 m x'^2": "a product is written 2*m",
    "L = T - V": "write 'lagrangian …'",
    "T = m/2*x'^2": "write 'kinetic …'",
    "U = k*x": "write 'potential …'",
    "H = T + V": "'lagrangian …'",
    "import math": "imports nothing",
    "from sympy import *": "imports nothing",
    "#include <math.h>\nusing Plots": "imports nothing",
    "for i in range(3):": "sum(m/2*q[i]'^2, i = 1..N)",
    "if x > 0": "if(x > 0, a, b)",
    "def f(x):": "let y =",
    "parameter m2 = 1": "did you mean 'param'?",
    "Real y": "coord x [m]",
    "syms y": "coord x [m]",
    "var y": "coord x [m]",
    "y = 3": "write 'let y = …'",
    "coord y = 0": "start y = …",
    "param b: 1": "param NAME = VALUE",
    "potential k*x;": "ends with its line",
    "potential k*x // spring": "begins with #",
    "// a comment": "begins with #",
    "% a comment": "begins with #",
    "/* a comment */": "begins with #",
    "potential \\frac{1}{2} k x^2": "is a/b",
    "coord \\theta": "is theta",
    "potential 2x": "2*x",
    "potential sin x": "sin(x)",
    "potential sin^2(x)": "sin(…)^2",
    "potential np.sin(x)": "no prefix",
    "potential pow(x, 2)": "x^y",
    "potential e^x": "exp(x)",
    "potential |x|": "abs(x)",
    "potential x if k else 0": "if(x > 0, a, b)",
    "potential x > 0 ? x : 0": "if(x > 0, a, b)",
    "damping 0.1*x'": "dissipation b/2*x'^2",
    "viscous 0.1": "dissipation b/2*x'^2",
    "initial x = 1": "start x = 1",
    "x(0) = 1": "start x = 1",
    "output E = x": "observe NAME",
    "simulate 10": "pkgen run",
    "param a = 90 deg": "90 [deg]",
    "param b = 1 kg": "1 [kg]",
    "param g = 9.81 m/s^2": "9.81 [m/s^2]",
}


@pytest.mark.parametrize("line", SAID)
def test_the_line_to_write_instead(line: str) -> None:
    with pytest.raises(ModelError) as said:
        check_model(from_text("h.lag", f"{HEAD}{line}\n"))
    assert SAID[line] in said.value.text()


def test_pi_in_degrees_is_asked_about() -> None:
    _, warnings = check_model(from_text("h.lag", f"{HEAD}start x = pi/2 [deg]\n"))
    assert any("write pi/2 [rad]" in w.help for w in warnings)
    _, warnings = check_model(from_text("h.lag", f"{HEAD}start x = 90 [deg]\n"))
    assert not warnings
