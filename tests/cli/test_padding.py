"""Parameters that no kernel reads change no number: runs copy them over memory that steps use."""

from __future__ import annotations

import pytest

from conftest import rows

MODELS = {
    "pendulum": "coord x\nkinetic x'^2/2\npotential -9.81*cos(x)\nstart x = 1, x' = 0.25\n",
    "two": "coord x, y\nkinetic x'^2/2 + y'^2/2 + cos(x - y)*x'*y'/3\n"
    "potential -9.81*cos(x) - 3*cos(y)\nstart x = 1, y' = 0.25\nevent low: x falling\n",
}


def motion(pkgen, write, name: str, padding: int, *options: str) -> list[dict[str, float]]:
    text = "".join(f"param a{k} = {k + 1}.5\n" for k in range(padding)) + MODELS[name]
    model = write(f"model {name}_{padding}\n{text}")
    return rows(pkgen, model, "--until", "2", "--every", "0.07", *options)


def far(a: list[dict[str, float]], b: list[dict[str, float]]) -> float:
    return max(abs(x[k] - y[k]) for x, y in zip(a, b, strict=True) for k in x)


@pytest.mark.parametrize("name", MODELS)
def test_rows_inside_steps(pkgen, write, name):
    plain = motion(pkgen, write, name, 0, "--method", "gauss")
    steps_of_its_own = motion(
        pkgen, write, name, 0, "--method", "dop853", "--rtol", "1e-12", "--atol", "1e-12"
    )
    assert len(plain) == 30
    assert 0 < far(plain, steps_of_its_own) < 1e-8 < far(plain, plain[1:] + plain[:1])
    for padding in (53, 300) if name == "pendulum" else (40, 103, 300):
        assert motion(pkgen, write, name, padding, "--method", "gauss") == plain
