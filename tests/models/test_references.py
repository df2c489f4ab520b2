"""Each of the five first models, end to end, against final states known to 25 digits.

The references were derived and integrated independently (their parameters, start and end time
stand with them). The worse method of each pair shows that the bound can fail.
"""

import json
from pathlib import Path

import pytest

from conftest import ran

ROOT = Path(__file__).resolve().parents[2]
REFERENCES = json.loads((Path(__file__).parent / "references.json").read_text())
BOUNDS = {name: 1e-9 if name == "heavy_top" else 1e-10 for name in REFERENCES}
# Steps at which gauss4 (order 8) has left its truncation error behind.
GAUSS_STEPS = {
    "double_pendulum": 0.005,
    "coupled_oscillators": 0.05,
    "bead_on_hoop": 0.005,
    "elastic_pendulum": 0.01,
    "heavy_top": 0.002,
}


def final_error(pkgen, name: str, *method: object) -> float:
    """Largest error of the final state, each component relative to max(1, its size)."""
    reference = REFERENCES[name]
    arguments = ["run", ROOT / "models" / f"{name}.lag", "--json", "--until", reference["t_end"]]
    for parameter, value in reference["params"].items():
        arguments += ["--set", f"{parameter}={value}"]
    names = [*reference["coords"], *(f"{c}'" for c in reference["coords"])]
    for coordinate, value in zip(names, reference["y0"], strict=True):
        arguments += ["--start", f"{coordinate}={value}"]
    done = ran(*arguments, "--every", reference["t_end"], *method)
    result = json.loads(done.stdout)
    last = dict(zip((c["name"] for c in result["columns"]), result["rows"][-1], strict=True))
    assert last["t"] == float(reference["t_end"])
    return max(
        abs(last[n] - float(y)) / max(1.0, abs(float(y)))
        for n, y in zip(names, reference["y"], strict=True)
    )


@pytest.mark.parametrize("name", REFERENCES)
def test_dop853(pkgen, name: str) -> None:
    assert 0 < final_error(pkgen, name, "--method", "dop853", "--rtol", "1e-14") < BOUNDS[name]
    assert final_error(pkgen, name, "--method", "dop853", "--rtol", "1e-5") > BOUNDS[name]


@pytest.mark.parametrize("name", REFERENCES)
def test_taylor(pkgen, name: str) -> None:
    assert 0 < final_error(pkgen, name, "--method", "taylor", "--rtol", "1e-14") < BOUNDS[name]
    assert final_error(pkgen, name, "--method", "taylor", "--rtol", "1e-4") > BOUNDS[name]


@pytest.mark.parametrize("name", REFERENCES)
def test_gauss(pkgen, name: str) -> None:
    assert 0 < final_error(pkgen, name, "--method", "gauss", "--rtol", "1e-13") < BOUNDS[name]
    assert final_error(pkgen, name, "--method", "gauss", "--rtol", "1e-5") > BOUNDS[name]


@pytest.mark.parametrize("name", REFERENCES)
def test_gauss4(pkgen, name: str) -> None:
    step = GAUSS_STEPS[name]
    assert 0 < final_error(pkgen, name, "--method", "gauss4", "--step", step) < BOUNDS[name]
    assert final_error(pkgen, name, "--method", "gauss1", "--step", step) > BOUNDS[name]


@pytest.mark.parametrize("name", REFERENCES)
def test_the_models_own_start_is_that_of_the_reference(pkgen, name: str) -> None:
    done = pkgen("run", ROOT / "models" / f"{name}.lag", "--json", "--until", "0.1")
    result = json.loads(done.stdout)
    first = dict(zip((c["name"] for c in result["columns"]), result["rows"][0], strict=True))
    reference = REFERENCES[name]
    names = [*reference["coords"], *(f"{c}'" for c in reference["coords"])]
    assert [first[n] for n in names] == [float(y) for y in reference["y0"]]
