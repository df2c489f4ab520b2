"""The model in WebAssembly against `pkgen run` of the same model, by the JavaScript that the page
calls, in node. Without a compiler to WebAssembly or node these are skipped."""

from __future__ import annotations

import csv
import io
import json
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest
from conftest import ROOT, run_pkgen
from pkgen.back.web.build import missing

RUNNER = Path(__file__).with_name("engine_runner.js")
NOT_HERE = missing() or ([] if shutil.which("node") else ["nodejs"])
pytestmark = pytest.mark.skipif(bool(NOT_HERE), reason=f"apt-get install {' '.join(NOT_HERE)}")
MODELS = sorted((ROOT / "models").rglob("*.lag"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("pages")


def page(model: Path, folder: Path, *more: str) -> Path:
    path = folder / f"{model.stem}{len(more)}.html"
    done = run_pkgen("show", model, "-o", path, *more)
    assert done.returncode == 0, done.stderr
    return path


def asked(path: Path, *jobs: dict) -> dict:
    done = subprocess.run(
        ["node", RUNNER, path], input=json.dumps(jobs), capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def rows(model: Path, description: dict, *options: str) -> list[list[float]]:
    """t, coordinates, rates of `pkgen run`, in the order of the description."""
    names = [c["name"] for c in description["coordinates"]]
    names += [c["rate"] for c in description["coordinates"]]
    rates = [n for r in description["rotations"] for n in r["rates"]]
    names += rates + [s["name"] for s in description["states"]]
    done = run_pkgen("run", model, "--record", ",".join(names), *options)
    assert done.returncode == 0, done.stderr
    found = list(csv.reader(io.StringIO(done.stdout)))
    return [[float(x) for x in row] for row in found[1:]]


@cache
def described(model: Path) -> dict:
    return json.loads(run_pkgen("describe", model, "--json").stdout)


def compare(model: Path, folder: Path, methods: list[tuple[str, dict, list[str]]]) -> int:
    description = described(model)
    times = [0.05 * k for k in range(1, 11)]
    path = page(model, folder)
    answers = asked(path, *({"times": times, "method": m, **job} for m, job, _ in methods))
    compared = 0
    for (method, _, options), found in zip(methods, answers["found"], strict=True):
        assert "error" not in found, f"{method}: {found['error']}"
        assert found["status"] == "", f"{method}: {found['status']}"
        ours = rows(
            model, description, "--method", method, "--until", "0.5", "--every", "0.05", *options
        )
        for a, b in zip(found["rows"], ours[1:], strict=True):
            size = max(1.0, *map(abs, b))
            worst = max(abs(x - y) for x, y in zip(_flat(description, answers, a), b, strict=True))
            assert worst < 1e-9 * size, (method, a, b)
            compared += 1
    return compared


def _flat(description: dict, answers: dict, row: list[float]) -> list[float]:
    """A row of the engine in the order of `rows`: quaternions and rates of bodies by name."""
    nq = answers["nq"]
    t, q, v = row[0], row[1 : 1 + nq], row[1 + nq :]
    by_name = {s["name"]: v[s["index"]] for s in description["states"]}
    turning = [n for r in description["rotations"] for n in r["rates"]]
    of_bodies = v[nq : nq + len(turning)]
    states = [by_name[s["name"]] for s in description["states"]]
    return [t, *q, *v[:nq], *of_bodies, *states]


FIXED = {"step": 0.01}
FAST = [
    ("gauss", {"rtol": 1e-12}, ["--rtol", "1e-12"]),
    ("dop853", {"rtol": 1e-12}, ["--rtol", "1e-12"]),
    ("rk4", FIXED, ["--step", "0.01"]),
    ("gauss4", FIXED, ["--step", "0.01"]),
]


@pytest.mark.parametrize("name", ["double_pendulum", "heavy_top", "coupled_oscillators"])
def test_motions_are_those_of_run(name: str, folder: Path) -> None:
    assert compare(ROOT / "models" / f"{name}.lag", folder, FAST) == 40


def test_a_scene_and_options_are_the_start(folder: Path) -> None:
    model = ROOT / "models" / "double_pendulum.lag"
    path = page(model, folder, "--set", "l2=0.5", "--start", "theta1=2")
    (found,) = asked(path, {"method": "gauss", "rtol": 1e-12, "times": [1.0]})["found"]
    options = "--set l2=0.5 --start theta1=2 --until 1 --every 1 --rtol 1e-12 --method gauss"
    ours = rows(model, described(model), *options.split())
    assert found["rows"][0] == pytest.approx(ours[-1], abs=1e-9)


def test_failures_have_words_and_the_last_time(folder: Path, tmp_path: Path) -> None:
    text = (
        "model falls\ncoord x\nparam k = 1 in (0, 5]\nkinetic x'^2/2\npotential -k/x\nstart x = 1\n"
    )
    (tmp_path / "falls.lag").write_text(text)
    found = asked(
        page(tmp_path / "falls.lag", folder),
        {"method": "gauss", "times": [1.0, 2.0]},
        {"method": "verlet", "times": [1.0], "step": -1},
        {"method": "nothing", "times": [1.0]},
        {"kind": "prepare", "params": [7.0]},
        {"kind": "prepare", "params": [2.0]},
    )["found"]
    assert "end here" in found[0]["status"] and found[0]["rows"][-1][0] == pytest.approx(
        1.1107, abs=1e-3
    )
    assert "step" in found[1]["error"] and found[2]["error"] == "there is no such method"
    assert found[3]["why"] == "k is outside its bounds" and found[4]["why"] is None


def test_events_constants_and_outputs(folder: Path) -> None:
    model = ROOT / "models" / "pendulums" / "pendulum.lag"
    (found,) = asked(page(model, folder), {"method": "gauss", "times": [3.0]})["found"]
    assert [e["event"] for e in found["events"]] == [0, 0, 0]
    assert found["constants"][0] == pytest.approx(found["energy"]) and len(found["outputs"]) > 2


def test_memory_is_given_back(folder: Path) -> None:
    path = page(ROOT / "models" / "double_pendulum.lag", folder)
    job = {"method": "gauss", "times": [0.1]}
    few, many = asked(path, *[job] * 20)["memory"], asked(path, *[job] * 2000)["memory"]
    assert many == few


def test_a_swarm_goes_as_its_members_do(folder: Path) -> None:
    model = ROOT / "models" / "double_pendulum.lag"
    path = page(model, folder)
    values = [x for k in range(7) for x in (0.1 * k, 0.3)]
    columns = [{"kind": "q", "index": 0}, {"kind": "v", "index": 1}]
    swarm = {
        "kind": "swarm",
        "method": "rk4",
        "step": 0.01,
        "members": 7,
        "columns": columns,
        "values": values,
    }
    single = [
        {"method": "rk4", "step": 0.01, "times": [0.5, 1.0], "q": [0.1 * k, -0.9], "v": [0.2, 0.3]}
        for k in range(7)
    ]
    first, *others = asked(path, {**swarm, "times": [0.5, 1.0]}, *single)["found"]
    assert first["statuses"] == ["", ""]
    for k, other in enumerate(others):
        assert first["states"][4 * k : 4 * k + 4] == pytest.approx(other["rows"][-1][1:], abs=1e-12)


def test_a_family_kept_as_loops(folder: Path) -> None:
    model = ROOT / "models" / "chains" / "fput.lag"
    methods = [("verlet", FIXED, ["--step", "0.01"]), ("gauss4", FIXED, ["--step", "0.01"])]
    assert compare(model, folder, [methods[0]]) == 10


def test_text_of_a_model_is_data_in_the_page(folder: Path, tmp_path: Path) -> None:
    text = "model constructor # </script><script>alert(1)</script>\n" + (
        "coord __proto_, hasOwnProperty # <img src=x onerror=alert(2)> \"'&\u2028\n"
        "kinetic (__proto_'^2 + hasOwnProperty'^2)/2\npotential __proto_^2\n"
    ).replace("__proto_", "proto")
    (tmp_path / "hostile.lag").write_text(text)
    made = page(tmp_path / "hostile.lag", folder).read_text()
    assert "alert(1)" in made and "<script>alert" not in made and "<img" not in made
    assert "\u2028" not in made


def test_a_page_is_made_to_the_same_bytes_and_is_small(folder: Path) -> None:
    model = ROOT / "models" / "double_pendulum.lag"
    first, second = page(model, folder).read_bytes(), page(model, folder).read_bytes()
    assert first == second and len(first) < 1_500_000


@pytest.mark.long
@pytest.mark.parametrize("model", MODELS, ids=lambda path: path.stem)
def test_every_method_of_every_model(model: Path, folder: Path) -> None:
    description = described(model)
    # With steps and tolerances that suit its time.
    methods = []
    for m in description["methods"]:
        if not m["applies"] or m["gsl"] or m["exact"]:
            continue
        if m["adaptive"]:
            methods.append((m["name"], {"rtol": 1e-11}, ["--rtol", "1e-11"]))
        else:
            methods.append((m["name"], {"step": 0.005}, ["--step", "0.005"]))
    assert methods and compare(model, folder, methods)
