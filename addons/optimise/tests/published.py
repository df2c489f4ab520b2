"""Models of optima that are published, or known in closed form."""

from __future__ import annotations

from pathlib import Path

import pytest

import pkgen
from conftest import written

SOLVERS = ["ipopt", "slsqp"]
BLOCK = """
model block
coord x
input F
param k = 0 in [0, 9]
lagrangian x'^2/2 - k*x^2/2 + F*x
observe twice = 2*x
"""
UNITS = """
model pushed
param m = 2 [kg]
coord x [m]
input F [N]
kinetic m*x'^2/2
potential (0 [N])*x
force x = F
"""
THROWN = """
model thrown
param angle = 0.3
param v = 10
param g = 9.81
coord x, y
lagrangian (x'^2 + y'^2)/2 - g*y
start x' = v*cos(angle)
start y' = v*sin(angle)
"""
CART_POLE = """
model cart_pole
param m1 = 1
param m2 = 0.3
param l = 0.5
param g = 9.81
coord x, theta
input F
kinetic m1/2*x'^2 + m2/2*(x'^2 + l^2*theta'^2 + 2*l*x'*theta'*cos(theta))
potential -m2*g*l*cos(theta)
force x = F
"""
STEERING = """
model steering
param a = 100
coord x, y
input s
kinetic (x'^2 + y'^2)/2
potential 0*x
force x = a*cos(s)
force y = a*sin(s)
"""
GODDARD = """
model goddard
param c = 0.5
state h, v, m
input T
let drag = 310*v^2*exp(-500*(h - 1))
rate h = v
rate v = (T - drag)/m - 1/h^2
rate m = -T/c
start h = 1
start v = 0
start m = 1
"""
ACROBOT = """
model acrobot
param m = 1
param l = 1
param lc = 0.5
param I = 1
param g = 9.8
coord q1, q2
input u
let w = q1' + q2'
kinetic (m*lc^2 + I)*q1'^2/2 + m/2*(l^2*q1'^2 + lc^2*w^2 + 2*l*lc*cos(q2)*q1'*w) + I*w^2/2
potential -m*g*(lc + l)*cos(q1) - m*g*lc*cos(q1 + q2)
force q2 = u
"""
# The compass walker (A. Goswami et al., Int. J. Robotics Research 17 (1998) 1282) on level ground,
# with a torque at the hip. s and n are the angles of the stance and of the swing leg.
WALKER = """
model walker
param mH = 10
param m = 5
param a = 0.5
param b = 0.5
param g = 9.81
coord s, n
input u
let l = a + b
kinetic mH*l^2*s'^2/2 + m*a^2*s'^2/2 + m*(l^2*s'^2 + b^2*n'^2 - 2*l*b*cos(s - n)*s'*n')/2
potential g*((mH*l + m*a + m*l)*cos(s) - m*b*cos(n))
force n = u
force s = -u
start s = -0.2
start n = 0.2
start s' = 1.3
start n' = -0.3
# angular momentum about the new foot, and of the new swing leg about the hip
let L1 = -m*a*b*n' + (-m*a*b + (mH*l^2 + 2*m*a*l)*cos(s - n))*s'
let L2 = -m*a*b*s'
let p11 = m*b*(b - l*cos(s - n))
let p12 = m*l*(l - b*cos(s - n)) + m*a^2 + mH*l^2
let p21 = m*b^2
let p22 = -m*b*l*cos(s - n)
let d = p11*p22 - p12*p21
observe n_rate = (L1*p22 - L2*p12)/d
observe s_rate = (p11*L2 - p21*L1)/d
observe foot = s + n
observe stride = 2*l*sin((s - n)/2)
"""


def best(tmp_path: Path, text: str, solver: str = "", **more):
    """The optimum, whose inputs in one run lead to where its intervals lead."""
    if solver == "ipopt":
        pytest.importorskip("cyipopt")
    found = pkgen.load(written(tmp_path, text)).optimise(solver=solver, **more)
    run = found.run(rtol=1e-10)
    for name, x in found.states.items():
        assert run[name][0] == pytest.approx(x[0], abs=1e-12)
        assert run[name][-1] == pytest.approx(x[-1], abs=1e-6)
    return found
