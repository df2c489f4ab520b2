"""Models to claim things of, and what becomes of the claims."""

from __future__ import annotations

from itertools import islice

from pkgen.compiler import stages
from pkgen.source import Source

KEPLER = """\
model kepler
param mu = 1 in (0, inf)
param eps = 0.1
coord x, y, z
let r = sqrt(x^2 + y^2 + z^2)
kinetic (x'^2 + y'^2 + z'^2)/2
potential -mu/r
let Lx = y*z' - z*y'
let Ly = z*x' - x*z'
let Lz = x*y' - y*x'
start x = 1, y' = 0.8, z' = 0.3
"""
LENZ = """\
conserve Ax = y'*Lz - z'*Ly - mu*x/r
conserve Ay = z'*Lx - x'*Lz - mu*y/r
conserve Az = x'*Ly - y'*Lx - mu*z/r
"""
POLAR = """\
model polar
param mu = 1 in (0, inf)
coord r, phi
kinetic (r'^2 + r^2*phi'^2)/2
potential -mu/r
let L = r^2*phi'
start r = 1, phi' = 0.8
"""
PENDULUM = """\
model pendulum
param g = 9.81
coord a
input u
kinetic a'^2/2
potential -g*cos(a)
start a = 1
"""
PAIR = "model pair\ncoord x, y\nkinetic (x'^2 + y'^2)/2\nstart x = 1, y = 1\n"
# Two links without gravity: dense M, whose denominators must cancel.
LINKS = """\
model links
param m = 1.3 in (0, inf)
coord a, b
let x = sin(a) + sin(b)
let y = -cos(a) - cos(b)
kinetic m/2*a'^2 + (x'^2 + y'^2)/2
"""


def claims(text, sizes=None):
    """No kernel but these is derived, which is quick; of families all are, to keep them loops."""
    kernels = None if "size " in text else frozenset({"acceleration", "conserve"})
    *_, structure = islice(stages(Source("x.lag", text), sizes or {}, kernels), 4)
    return structure.claims


def outcomes(text, **sizes):
    return [claim.outcome for claim in claims(text, sizes)]
