"""Models of the tests of continuation."""

from pathlib import Path

import pkgen
from conftest import ROOT
from pkgen_bifurcation import branches

VAN_DER_POL = """
model van_der_pol
param mu = 1
coord x
lagrangian x'^2/2 - x^2/2
force x = mu*x' - x^2*x'
event right: x rising
start x = 1.9
"""
DUFFING = """
model duffing
param omega = 0.5 in (0, inf)
param T = 2*pi/omega
coord x
lagrangian x'^2/2 - x^2/2 - x^4/4 + 0.5*x*cos(omega*t)
dissipation 0.05*x'^2
"""
ROSSLER = """
model rossler
param c = 2.5
state x, y, z
rate x = -y - z
rate y = x + 0.2*y
rate z = 0.2 + z*(x - c)
start x = 1, y = 1
"""
# A mass ratio and a start of K. C. Howell, Celestial Mechanics 32 (1984) 53, table I.
HALO = """
model halo
param mu = 0.04 in (0, 0.5]
coord x, y, z
let r1 = sqrt((x + mu)^2 + y^2 + z^2)
let r2 = sqrt((x - 1 + mu)^2 + y^2 + z^2)
lagrangian ((x' - y)^2 + (y' + x)^2 + z'^2)/2 + (1 - mu)/r1 + mu/r2
start x = 0.729988, z = 0.215589, y' = 0.397259
"""
HOOP = ROOT / "models/bead_on_hoop.lag"
KEPLER = ROOT / "models/particles/kepler.lag"
THREE = ROOT / "models/particles/restricted_three_body.lag"


def loaded(of: str | Path, folder: Path, scene: str | None = None) -> pkgen.Model:
    """Returns a model of a file, or of a text, which is written to `folder`."""
    if isinstance(of, Path):
        return pkgen.load(of, scene)
    path = folder / f"{of.split()[1]}.lag"
    path.write_text(of)
    return pkgen.load(path, scene)


def found(of: str | Path, folder: Path, free: str, low, high, scene=None, **more):
    """Returns the branches of a model."""
    return branches(loaded(of, folder, scene), free, (low, high), **more)


def kinds(of) -> list[str]:
    return [point.kind for point in of.special]
