"""Which particles a kinetic energy is of, by its text; and that the kernel of a model has them."""

from __future__ import annotations

import pytest
from pkgen.back.kernels import KERNELS
from pkgen.compiler import check_model, compile_model
from pkgen.middle import particles as reading
from pkgen.source import Source

PLANE = "coord x, y\n"
POLAR = "coord r, phi\nparam m = 2 in (0, inf)\nstart r = 1\n"
FAMILY = "size N = 3\nparam m[i = 1..N] = i in (0, inf)\ncoord x[1..N], y[1..N], z[1..N]\n"
FOUND = {  # a model, and how many particles it has
    PLANE + "kinetic (x'^2 + y'^2)/2": 1,
    PLANE + "kinetic x'^2/2\nkinetic y'*y'/2": 1,
    PLANE + "let v2 = x'^2 + y'^2\nkinetic 0.5*v2": 1,
    PLANE + "let r = [x, y, 0]\nkinetic dot(r', r')/2": 1,
    PLANE + "let r = [x, y, 0]\nkinetic norm(r')^2/2": 1,
    PLANE + "let r = [x, y, 0]\nkinetic ((r.x)'^2 + (r.y)'^2)/2": 1,
    "coord a_x, a_y, b_x, b_y\nkinetic (a_x'^2 + a_y'^2)/2 + b_x'^2 + b_y'^2": 2,
    POLAR + "let x = r*cos(phi)\nlet y = r*sin(phi)\nkinetic m/2*(x'^2 + y'^2)": 1,
    POLAR + "kinetic m/2*((r*cos(phi))'^2 + (r*sin(phi))'^2)": 1,
    POLAR + "kinetic m/2*(r'^2 + r^2*phi'^2)": 1,
    POLAR + "kinetic m/2*r'^2 + m/2*(r*phi')^2": 1,
    "coord r, a, b\nstart r = 1, a = 1\nkinetic (r'^2 + r^2*a'^2 + r^2*sin(a)^2*b'^2)/2": 1,
    FAMILY + "kinetic sum(m[i]/2*(x[i]'^2 + y[i]'^2 + z[i]'^2), i = 1..N)": 3,
    FAMILY + "kinetic sum(m[i]/2*x[i]'^2, i = 1..N) + sum(m[i]/2*y[i]'^2, i = 1..N)\n"
    "kinetic sum(m[i]/2*z[i]'^2, i = 1..N)": 3,
}
NOT = {  # and of others where they say what
    "coord x\nkinetic x'^2/2": "no x and y of one mass",
    "coord x1, x2\nkinetic (x1'^2 + x2'^2)/2": "no x and y of one mass",
    "coord u, w\nkinetic (u'^2 + w'^2)/2": "names do not say",
    PLANE + "kinetic x'^2 + y'^2/2": "no x and y of one mass",
    PLANE + "kinetic ((x' - y)^2 + (y' + x)^2)/2": "no square of a rate",
    PLANE + "kinetic (x'^2 + y'^2 + x'*y')/2": "product of different rates",
    PLANE + "lagrangian (x'^2 + y'^2)/2": "the model states its L",
    PLANE + "kinetic (1 + x^2)*(x'^2 + y'^2)/2": "a mass that varies",
    POLAR + "kinetic m/2*(r'^2 + 2*r^2*phi'^2)": "names do not say",
    PLANE + "coord a\nkinetic (x'^2 + y'^2)/2 + a'^2": "names do not say",
}
ALL = frozenset(KERNELS) - {"hamiltonian", "hamilton", "hamilton_force"}


def particles(text: str, kernels: frozenset[str] | None = ALL):
    compilation = compile_model(Source("a.lag", f"model a\n{text}\n"), kernels=kernels)
    return compilation.equations.particles, compilation


@pytest.mark.parametrize("text", FOUND)
def test_found(text: str) -> None:
    found, compilation = particles(text)
    assert found.why == "" and len(found.masses) == FOUND[text]
    assert f".n_particles = {FOUND[text]}," in compilation.files["a.c"]


@pytest.mark.parametrize("text", NOT)
def test_not_of_particles(text: str) -> None:
    found, compilation = particles(text)
    assert NOT[text] in found.why and not found.masses
    assert compilation.model.source.place(found.span).startswith("a.lag:")
    assert "particles" not in compilation.files["a.c"]


def test_what_is_read_is_proved(monkeypatch) -> None:
    # A reader that takes the angle for the radius finds particles of another kinetic energy.
    right = reading._polar
    monkeypatch.setattr(reading, "_polar", lambda x, group: right(x, group[::-1]) or _wrong(group))
    found, _ = particles(POLAR + "kinetic m/2*(r'^2 + r^2*phi'^2)")
    assert "is not proved" in found.why and not found.masses


def _wrong(group):
    places = tuple(square.place for square in group)
    return reading._Body(group[0].factor, (*places, reading.ZERO))


def test_only_where_they_are_asked_for() -> None:
    found, compilation = particles(PLANE + "kinetic (x'^2 + y'^2)/2", None)
    assert found is None and "particles" not in compilation.files["a.c"]
    assert check_model(compilation.model.source)
