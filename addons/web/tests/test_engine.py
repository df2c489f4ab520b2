"""The model in WebAssembly against `pkgen run` of the same model, by the JavaScript that the page
calls, in node. Without a compiler to WebAssembly or node these are skipped."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import native
import pytest

from conftest import ROOT, SHOWN, long_but, run_pkgen
from pkgen.back.wasm import build
from pkgen.system.exits import BuildError

RUNNER = Path(__file__).with_name("engine_runner.js")
NOT_HERE = build.missing() or ([] if shutil.which("node") else ["nodejs"])
pytestmark = pytest.mark.skipif(bool(NOT_HERE), reason=f"apt-get install {' '.join(NOT_HERE)}")
MODELS = SHOWN


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


EVERY = 0.0473  # within steps
TIMES = [EVERY * k for k in range(1, 11)]


def asked_of(method: dict) -> dict:
    """Short steps and tight tolerances: what is seen are differences of the code."""
    if method["adaptive"]:
        return {"rtol": 1e-11, "step": None}
    return {"step": 0.005}


def compare(model: Path, folder: Path, every: float = EVERY) -> int:
    """Every method that applies against this machine's C; the number of states compared."""
    times = [every * k for k in range(1, 11)]
    native_ = native.made(model)
    methods = [m for m in native_.description["methods"] if m["applies"] and not m["gsl"]]
    jobs = [{"times": times, "method": m["name"], **asked_of(m)} for m in methods]
    compared = 0
    # Steps that end at knots of a table, or just before, are of different lengths afterwards.
    within = 1e-5 if native_.description["tables"] else 1e-9
    for method, found in zip(methods, asked(page(model, folder), *jobs)["found"], strict=True):
        name = method["name"]
        why, rows = native.rows(native_, method, until=times[-1], every=every, **asked_of(method))
        if "no step" in found.get("error", "") and "no step" in why:
            continue  # adaptive_verlet of forces without a gradient
        assert "error" not in found, f"{name}: {found['error']}"
        assert bool(found["status"]) == bool(why), f"{name}: {found['status']}; {why}"
        ours = found["rows"][:-1] if why else found["rows"]
        assert len(ours) == len(rows) - 1, name
        for a, b in zip(ours, rows[1:], strict=True):
            size = max(1.0, *map(abs, b))
            assert max(abs(x - y) for x, y in zip(a, b, strict=True)) < within * size, (name, a, b)
            compared += 1
    return compared


# A mechanism, a rotation, constraints, switches and events, a family kept as loops.
SOME = (
    "double_pendulum",
    "bodies/free_body",
    "constrained/pendulum_rod",
    "pendulums/pendulum",
    "chains/fput",
)


@pytest.mark.parametrize("name", long_but(["bodies/free_body"], SOME))
def test_every_method_goes_as_in_a_run(name: str, folder: Path) -> None:
    assert compare(ROOT / "models" / f"{name}.lag", folder) >= 150


HIT = {"rocking_block": 0.3773, "bouncing_ball": 0.3773, "stick_slip_belt": 1.7073}


@pytest.mark.parametrize("name", long_but(["rocking_block"], HIT))
def test_contacts_go_as_in_a_run(name: str, folder: Path) -> None:
    """They close, stick and open again within these times."""
    assert compare(ROOT / "models" / "contact" / f"{name}.lag", folder, every=HIT[name]) >= 200


def test_a_contact_slides_over_a_kink_as_in_a_run(folder: Path, tmp_path: Path) -> None:
    """Its rates break the closed gap behind the kink, where it opens."""
    text = "model kink\ncoord x, y\nkinetic (x'^2 + y'^2)/2\npotential y\n"
    text += "contact floor: y - min(x/2, 1 - x/2) >= 0\nstart x = 0.2, y = 0.1, x' = 2, y' = 1\n"
    (tmp_path / "kink.lag").write_text(text)
    assert compare(tmp_path / "kink.lag", folder, every=0.3) >= 200


def test_own_methods_and_a_fast_part_go_as_in_a_run(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "own3.tab").write_text("A\n0\n1/3\n0 2/3\nb 1/4 0 3/4\n")
    (tmp_path / "pair.tab").write_text("A\n0\n1\nb 1/2 1/2\nbhat 1 0\n")
    text = "model own\ncoord x\nmethod own3 tableau own3.tab\nmethod pair tableau pair.tab\n"
    text += "kinetic x'^2/2\npotential 50*x^2 - cos(x)\nfast 50*x^2\nstart x = 1\n"
    (tmp_path / "own.lag").write_text(text)
    described = native.made(tmp_path / "own.lag").description["methods"]
    offered = {m["name"] for m in described if m["applies"]}
    assert {"own3", "pair", "respa", "respa4"} <= offered
    assert compare(tmp_path / "own.lag", folder) >= 150


def test_a_page_moves_a_model_of_its_own_scale(folder: Path) -> None:
    """What is compared above would be seen: another method differs by more."""
    model = ROOT / "models" / "double_pendulum.lag"
    rk2, rk4 = (
        found["rows"][-1]
        for found in asked(
            page(model, folder),
            *({"times": TIMES, "method": m, "step": 0.005} for m in ("rk2", "rk4")),
        )["found"]
    )
    assert max(abs(x - y) for x, y in zip(rk2, rk4, strict=True)) > 1e-6


@pytest.mark.parametrize(
    ("name", "given", "shown"),
    [
        ("double_pendulum", "--set l2=0.5 --start theta1=2", "theta1,theta2,theta1',theta2'"),
        ("bodies/free_body", "--start omega(R).x=3", "omega(R),R.w,R.x,R.y,R.z"),
    ],
)
def test_a_scene_and_options_are_the_start(name: str, given: str, shown: str, folder: Path) -> None:
    model = ROOT / "models" / f"{name}.lag"
    path = page(model, folder, *given.split())
    (found,) = asked(path, {"method": "gauss", "rtol": 1e-12, "times": [1.0]})["found"]
    options = f"{given} --until 1 --every 1 --rtol 1e-12 --method gauss"
    done = run_pkgen("run", model, "--record", shown, *options.split())
    last = [float(x) for x in done.stdout.splitlines()[-1].split(",")]
    assert found["rows"][0] == pytest.approx(last, abs=1e-9)


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
    name = native.made(model).description["events"][0]["name"]
    done = run_pkgen("run", model, "--at", name, "--record", "theta,theta'", "--until", "3")
    ours = [[float(x) for x in row.split(",")] for row in done.stdout.splitlines()[1:]]
    for crossing, row in zip(found["events"], ours, strict=True):
        state = [crossing["t"], *crossing["q"], *crossing["v"]]
        assert state == pytest.approx(row[-3:], abs=1e-8)
    assert found["constants"][0] == pytest.approx(found["energy"]) and len(found["outputs"]) > 2


def test_memory_is_given_back(folder: Path) -> None:
    path = page(ROOT / "models" / "double_pendulum.lag", folder)
    job = {"method": "gauss", "times": [0.1]}
    few, many = asked(path, *[job] * 20)["memory"], asked(path, *[job] * 2000)["memory"]
    assert many == few


def test_memory_of_parameters_and_swarms_is_given_back(folder: Path) -> None:
    """Each with parameters of its own, as a slider that is moved asks for them."""
    model = ROOT / "models" / "double_pendulum.lag"
    path, values = (
        page(model, folder),
        [p["value"] for p in native.made(model).description["parameters"]],
    )

    def jobs(count: int) -> list[dict]:
        found: list[dict] = []
        for k in range(count):
            own = [*values[:-1], values[-1] * (1 + 1e-3 * k)]
            found.append({"method": "rk4", "step": 0.01, "times": [0.1], "params": own})
            masses = [values[0] * (1 + i) for i in range(50)]
            swarm = {"columns": [{"kind": "p", "index": 0}], "values": masses, "times": [0.1]}
            found.append({"kind": "swarm", "method": "rk4", "step": 0.01, "members": 50, **swarm})
        return found

    few, many = asked(path, *jobs(40)), asked(path, *jobs(1500))
    assert many["memory"] == few["memory"]
    assert not [found for found in many["found"] if "error" in found]


def test_a_swarm_keeps_to_the_grid_of_its_steps(folder: Path) -> None:
    """However often it is shown: else symplectic methods would lose what they keep."""
    columns = [{"kind": "q", "index": 0}]
    swarm = {
        "kind": "swarm",
        "method": "rk4",
        "step": 0.02,
        "members": 3,
        "columns": columns,
        "values": [0.1, 0.2, 0.3],
    }
    often = [0.0137 * k for k in range(1, 71)]
    one, many = asked(
        page(ROOT / "models" / "double_pendulum.lag", folder),
        {**swarm, "times": often[-1:]},
        {**swarm, "times": often},
    )["found"]
    assert many["states"] == pytest.approx(one["states"], rel=1e-14)


def test_what_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build, "_found", lambda: (None, None, None))
    with pytest.raises(BuildError, match="apt-get install clang lld wasi-libc"):
        build.wasm({}, "m")


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
    noisy = "\nnoise " in model.read_text(encoding="utf-8")  # for which there are three methods
    assert compare(model, folder) >= (30 if noisy else 90)
