"""Forces, barriers and ramps of a width that is a small part of a step: seen by adaptive steps,
warned of by fixed ones. Against closed forms, quadratures of mpmath, extrapolated midpoint steps
of a quarter of the width, and the same model by steps that resolve it."""

from __future__ import annotations

import json
import random

import pytest

from conftest import expanded, seeds

PLACES = {
    "potential": "potential A*F(x - S)",
    "force": "force y = A*F(t - S)/w",
    "force of rates": "force y = A*F(x - S)*x'/w",
    "mass": "kinetic A*F(x - S)^2*y'^2",
    "let": "let p = x - S + 0.1*y\npotential A*F(p)",
    "moving": "potential A*F(x - S + 0.2*sin(3*t))",
    "pillar": "potential A*F(100*((x - S)^2 + (0.02*y)^2))",
    "state": "state e\nrate e = -e + A*F(x - S)/w\nforce y = e",
    "constraint": "constraint c: z = A*F(x - S)\nstart z = A*F(-S)",
    "constraint in t": "constraint c: z = A*F(t - S)\nstart z = A*F(-S)",
    "rolling": "rolling r: z' = A*F(x - S)\nstart z' = A*F(-S)",
    "hold": "HELD hold z = A*F(t - S)",
    "input": "force y = u/w\nHELD set u = A*F(t - S)",
}
# Beyond u = 236 cosh(u)^3, which second derivatives have, is no number.
FUNCTIONS = (
    "exp(-(({0})/w)^2)",
    "tanh(({0})/w)",
    "1/cosh(({0})/w)",
    "1/(1 + exp(({0})/w))",
    "1/(1 + (({0})/w)^2)",
    "1/(1 + (({0})/w)^2)^3",
    "1/sqrt(1 + (({0})/w)^8)",
    "((({0})/w)/(1 + (({0})/w)^4)^(1/4))",
)


def model_of(place: str, function: str, start: float) -> str:
    text, _, clause = PLACES[place].partition("HELD ")
    more = "input u\n" if place == "input" else ""
    text = (
        "model m\nparam w = 8e-3\nparam A = 0.3\ncoord x, y, z\n"
        f"{more}kinetic (x'^2 + y'^2 + z'^2)/2 + 0.2*y'*z' + 0.3*x'*z'\n"
        f"potential y^2/2\n{text}\nstart x' = 1.5, y = 0.2\nscene s\n  until 1.6\n  {clause}\nend\n"
    )
    return expanded(text, "F", function).replace("S", str(start))


@pytest.mark.parametrize("seed", seeds(range(3), 17))
def test_wherever_it_stands(pkgen, write, seed: int) -> None:
    """Random places and functions, by default settings and by steps of a third of the width."""
    draw = random.Random(seed)
    for place in draw.sample(sorted(PLACES), 2):
        # Those that fade by powers have a rate where constraints are to start.
        flat = 4 if place in ("constraint", "constraint in t", "rolling") else 8
        function = draw.choice(FUNCTIONS[: 2 if place == "pillar" else flat])
        path = write(model_of(place, function, draw.uniform(0.9, 1.3)))
        every = ("run", path, "--scene", "s", "--every", "1.6", "--json")
        ends = []
        resolved = ("--method", "dop853", "--rtol", "1e-12", "--max-step", "2.5e-3")
        for more in ((), resolved, (*resolved, "--set", "A=0")):
            done = pkgen(*every, *more)
            assert done.returncode == 0, (path.read_text(), done.stderr)
            ends.append(json.loads(done.stdout)["rows"][-1][1:7])
        found, right, without = ends
        assert max(abs(x - y) for x, y in zip(right, without, strict=True)) > 1e-5, path.read_text()
        assert found == pytest.approx(right, rel=1e-6, abs=1e-6), path.read_text()
