"""Models to claim things of, and what becomes of the claims."""

from itertools import islice

from conftest import case
from pkgen.compiler import stages
from pkgen.source import Source

KEPLER = case("claims_kepler")
LENZ = """\
conserve Ax = y'*Lz - z'*Ly - mu*x/r
conserve Ay = z'*Lx - x'*Lz - mu*y/r
conserve Az = x'*Ly - y'*Lx - mu*z/r
"""
POLAR = case("polar")
PENDULUM = case("claims_pendulum")
PAIR = "model pair\ncoord x, y\nkinetic (x'^2 + y'^2)/2\nstart x = 1, y = 1\n"
# Two links without gravity: dense M, whose denominators must cancel.
LINKS = case("links")


def claims(text, sizes=None):
    """No kernel but these is derived, which is quick; of families all are, to keep them loops."""
    kernels = None if "size " in text else frozenset({"acceleration", "conserve"})
    *_, structure = islice(stages(Source("x.lag", text), sizes or {}, kernels), 4)
    return structure.claims


def outcomes(text, **sizes):
    return [claim.outcome for claim in claims(text, sizes)]
