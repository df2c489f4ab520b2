"""Tables of data in runs: other files, arrays, long tables, built programs, checkpoints."""

import copy
import json
import pickle
import subprocess
from pathlib import Path

import numpy as np
import pytest

import pkgen
from conftest import ran, run_pkgen

MODEL = """model shaken
table road = "road.csv" x [s], y [mm] spline outside hold
coord x [m]
kinetic x'^2/2*(1 [kg])
potential (x - road(t))^2/2*(9 [N/m])
scene run
  until 4
  method dop853 rtol 1e-11
  record x every 1
end
"""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    x = np.linspace(0, 5, 21)
    rows = "".join(f"{a},{1000 * b}\n" for a, b in zip(x, np.sin(x) ** 2, strict=True))
    (tmp_path / "road.csv").write_text("x,y\n" + rows)
    (tmp_path / "double.csv").write_text(
        "y,x\n" + "".join(f"{2000 * np.sin(a) ** 2},{a}\n" for a in x)
    )
    path = tmp_path / "shaken.lag"
    path.write_text(MODEL)
    return path


def last(text: str) -> float:
    return float(text.splitlines()[-1].split(",")[1])


def test_a_file_in_place_of_the_models(model: Path) -> None:
    once = last(ran("run", model, "--scene", "run").stdout)
    other = model.parent / "double.csv"
    twice = last(ran("run", model, "--scene", "run", "--table", f"road={other}").stdout)
    assert twice == pytest.approx(2 * once, rel=1e-9)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("road", "give a table once"),
        ("rod=double.csv", "the model has no such table; it has: road"),
        ("road=nowhere.csv", "No such file"),
    ],
)
def test_wrong_files(model: Path, given: str, said: str) -> None:
    done = run_pkgen("run", model, "--scene", "run", "--table", given)
    assert done.returncode and said in done.stderr and "Traceback" not in done.stderr


def test_arrays_and_long_tables_in_place_of_the_file(model: Path) -> None:
    m = pkgen.load(model, scene="run")
    before = m.run()["x"][-1]
    x, y = m.tables["road"]
    assert len(m.tables) == 1 and [*m.tables] == ["road"] and y[4] == pytest.approx(np.sin(1) ** 2)
    m.tables["road"] = (x, 3 * y)
    assert m.run()["x"][-1] == pytest.approx(3 * before, rel=1e-9)
    x = np.linspace(-1, 6, 40_000)  # its numbers are not in the C
    m.tables["road"] = (x, np.sin(x) ** 2)
    assert "NULL" in m.compilation.files["shaken.c"] and len(m.compilation.files["shaken.c"]) < 2e4
    t = 4.0  # x'' + 9 x = 9 sin(t)^2
    exact = 0.5 - 0.9 * np.cos(2 * t) + 0.4 * np.cos(3 * t)
    assert m.run()["x"][-1] == pytest.approx(exact, abs=1e-8)
    del m.tables["road"]
    assert m.run()["x"][-1] == before
    with pytest.raises(KeyError, match="did you mean 'road'"):
        m.tables["rod"] = (x, x)
    for wrong in ((x, x[1:]), (x[::-1], x), (x,), (x, x, x), 3, ("a", "b"), (x, x * np.nan)):
        with pytest.raises(pkgen.UsageError, match=r"tables\['road'\]"):
            m.tables["road"] = wrong


def test_inputs_interpolate_as_tables_do(tmp_path: Path) -> None:
    path = tmp_path / "m.lag"
    path.write_text("model m\ninput u\ncoord x\nkinetic x'^2/2\nforce x = u\n")
    m, t = pkgen.load(path), np.linspace(0, 3, 31)
    ends = [
        m.run(3, inputs={"u": (t, np.cos(t), kind)}, rtol=1e-11)["x"][-1]
        for kind in ("linear", "hold", "pchip", "spline")
    ]
    errors = np.abs(np.array(ends) - (1 - np.cos(3)))
    assert errors[3] < errors[2] < errors[0] < errors[1] and errors[3] < 1e-5
    with pytest.raises(pkgen.UsageError, match="kind one of linear, spline, pchip, hold"):
        m.run(3, inputs={"u": (t, t, "cubic")})


def test_a_built_program_and_a_description_have_the_table(model: Path) -> None:
    ran("build", model, "--scene", "run", "-o", model.parent / "program")
    said = ran("run", model, "--scene", "run").stdout
    done = subprocess.run([model.parent / "program"], capture_output=True, text=True, check=True)
    assert last(done.stdout) == last(said)
    (table,) = json.loads(ran("describe", model, "--json").stdout)["tables"]
    assert table["units"] == ["s", "m"] and table["knots"] == [21] and table["kind"] == "spline"


def test_beyond_the_data_the_run_ends_and_says_so(model: Path) -> None:
    model.write_text(MODEL.replace(" outside hold", "").replace("until 4", "until 6"))
    done = run_pkgen("run", model, "--scene", "run")
    assert done.returncode == 4 and "last valid time 5" in done.stderr
    assert "there are no values outside of the data of road" in done.stderr


def test_other_data_are_another_model_for_checkpoints(tmp_path: Path) -> None:
    digests = []
    for y in (1, 2):
        (tmp_path / "road.csv").write_text(f"x,y\n0,0\n1,{y}\n")
        (tmp_path / "shaken.lag").write_text(MODEL)
        digests.append(
            json.loads(ran("describe", tmp_path / "shaken.lag", "--json").stdout)["sha256"]
        )
    assert digests[0] != digests[1]


def test_arrays_go_with_a_model_that_is_copied(model: Path) -> None:
    m = pkgen.load(model, scene="run")
    x, y = m.tables["road"]
    m.tables["road"] = (x, 3 * y)
    for other in (copy.deepcopy(m), pickle.loads(pickle.dumps(m))):
        assert other.run()["x"][-1] == m.run()["x"][-1]


def test_a_program_takes_no_long_table(model: Path) -> None:
    rows = "".join(f"{k / 6000},{k}\n" for k in range(30_001))
    (model.parent / "road.csv").write_text("x,y\n" + rows)
    done = run_pkgen("build", model, "--scene", "run", "-o", model.parent / "program")
    assert done.returncode == 2
    assert "the table road has 120,008 numbers, of at most 100,000" in done.stderr


def test_a_table_that_bends_is_told(model: Path) -> None:
    assert "road of the motion" not in ran("check", model).stderr
    model.write_text(MODEL.replace("spline", "linear"))
    assert "potential contains road of the motion" in ran("check", model).stderr


@pytest.mark.parametrize("force", ["wave(t)", "abs(mod(t + 1, 2) - 1)"])
def test_fixed_steps_that_end_at_rows_see_them(tmp_path: Path, force: str) -> None:
    """A start at a row was taken for a wrong guess of the piece at the next row that a step met."""
    (tmp_path / "wave.csv").write_text("x,y\n0,0\n1,1\n2,0\n3,1\n4,0\n")
    path = tmp_path / "pushed.lag"
    path.write_text(
        'model pushed\ntable wave = "wave.csv" x, y\ncoord x\nkinetic x\'^2/2\n'
        f"force x = {force} + 0*wave(t)\n"
    )
    for step in ("0.1", "0.25", "1"):
        out = ran("run", path, "--until", 3.5, "--every", 3.5, "--method", "rk4", "--step", step)
        assert last(out.stdout) == pytest.approx(145 / 48, abs=1e-12), step
