"""The map of a sweep: pixels are means of the members in them; a page has a member of each."""

from __future__ import annotations

import json
from pathlib import Path

import numpy
import pytest

from conftest import ROOT
from pkgen.system.exits import UsageError
from pkgen_sweep import map as sweep

arrow = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")
STATUSES = ["PK_DONE", "PK_STOPPED_EVENT", "PK_DIVERGED"]


def data_set(folder: Path, rng: numpy.random.Generator, grid: bool, members: int) -> dict:
    """A folder as `pkgen sweep` leaves it, in two parts, of what is returned."""
    at = {
        "x(0)": rng.integers(0, 7, members) / 3 if grid else rng.uniform(-2, 5, members),
        "m": rng.uniform(1, 2, members),
        "v": rng.integers(-4, 5, members) * 0.1 if grid else rng.normal(size=members),
    }
    columns = {"member": numpy.arange(1, members + 1), **at}
    columns["status"] = rng.choice(3, members, p=[0.7, 0.1, 0.2])
    found = rng.normal(size=members)
    found[(columns["status"] == 2) | (rng.random(members) < 0.1)] = numpy.nan
    columns["t"], columns["max(x)"] = numpy.ones(members), found
    drawn = {"description": "drawn by the plan", "unit": "m"}
    fields = []
    for name in columns:
        kind = {"member": arrow.int64(), "status": arrow.dictionary(arrow.int8(), arrow.string())}
        about = drawn if name in at else {"unit": "m"} if name == "max(x)" else None
        fields.append(arrow.field(name, kind.get(name, arrow.float64()), metadata=about))
    schema = arrow.schema(fields, metadata={"pkgen": json.dumps({"model": "m"})})
    (folder / "data").mkdir()
    (folder / "plan.json").write_text(json.dumps({"digest": ""}))
    for part, rows in enumerate(numpy.array_split(numpy.arange(members), 2)):
        made = []
        for name, x in columns.items():
            if name == "status":
                codes = arrow.array(x[rows].astype(numpy.int8))
                made.append(arrow.DictionaryArray.from_arrays(codes, arrow.array(STATUSES)))
            else:
                missing = numpy.isnan(x[rows]) if x.dtype == float else None
                made.append(arrow.array(x[rows], mask=missing))
        table = arrow.Table.from_arrays(made, schema=schema)
        file = folder / "data" / f"part-{part:06d}.parquet"
        parquet.write_table(table, file, row_group_size=37)
    return columns


@pytest.mark.parametrize("seed", range(6))
def test_pixels_are_means_of_their_members(seed: int, tmp_path: Path) -> None:
    rng = numpy.random.default_rng(seed)
    columns = data_set(tmp_path, rng, seed % 2 == 0, int(rng.integers(600, 1500)))
    value = rng.choice(["max(x)", sweep.FAILED])
    found = sweep.read(tmp_path, ("v", "x"), value, most=int(rng.integers(9, 40)))
    of = columns["max(x)"] if value == "max(x)" else (columns["status"] == 2).astype(float)
    pixels: dict[tuple[int, int], list[int]] = {}
    for k, place in enumerate(zip(columns["x(0)"], columns["v"], strict=True)):
        row = int(numpy.argmin(abs(found.at_y - place[0])))
        pixels.setdefault((row, int(numpy.argmin(abs(found.at_x - place[1])))), []).append(k)
    for place in numpy.ndindex(found.values.shape):
        inside = pixels.get(place, [])
        good = [of[k] for k in inside if numpy.isfinite(of[k])]
        assert found.values[place] == (
            pytest.approx(sum(good) / len(good)) if good else pytest.approx(numpy.nan, nan_ok=True)
        )
        assert found.first[place] == (inside[0] + 1 if inside else 0)
        if inside:
            assert all(x[place] == columns[name][inside[0]] for name, x in found.drawn.items())
    assert (found.members, found.without) == (len(of), int(numpy.isnan(of).sum()))
    assert found.averaged == ("m",)
    assert sweep.member(tmp_path, 501)["m"] == columns["m"][500]


def test_what_is_wrong_is_said(pkgen, tmp_path: Path) -> None:
    data_set(tmp_path, numpy.random.default_rng(0), False, 800)
    said = {
        ("--columns", "max(y)"): "nothing is kept as max(y); did you mean 'max(x)'?",
        ("--columns", "t,m"): "a map is of one",
        ("--map", "x,w"): "the plan draws no w; it has: x, m, v",
        ("--map", "x"): "a map has two axes that the plan draws; it has x(0), m, v",
        ("--path", "x,v"): "--path is of motions",
        ("--until", "3"): "--until is of a run",
        (ROOT / "models/kepler.lag",): "a sweep has a picture of its own",
    }
    for words, message in said.items():
        done = pkgen("plot", tmp_path, *words)
        assert done.returncode == 2 and message in done.stderr, done.stderr
    with pytest.raises(UsageError, match="no member 801"):
        sweep.member(tmp_path, 801)
    (tmp_path / "data/part-000001.parquet").write_bytes(b"PAR1 torn")
    done = pkgen("plot", tmp_path)
    assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
    done = pkgen("plot", ROOT / "models/kepler.lag", "--map", "x,y")
    assert done.returncode == 2 and "--map is of a sweep" in done.stderr


def test_of_a_sweep_that_was_run(pkgen, tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'until = 1\nmethod = "rk4"\nstep = 0.01\nkeep = ["max(theta2)"]\nset = ["m1=2 [kg]"]\n'
        '[grid]\ntheta1 = ["-1 .. 1 [rad]", 6]\ntheta2 = ["0 .. 30 [deg]", 5]\n'
    )
    model = ROOT / "models/double_pendulum.lag"
    done = pkgen("sweep", model, "--plan", plan, "-o", tmp_path / "s")
    assert done.returncode == 0, done.stderr
    done = pkgen("plot", tmp_path / "s", "--json", "-o", tmp_path / "map.png")
    assert done.returncode == 0, done.stderr
    assert "max(theta2) [rad]" in done.stdout
    found = sweep.read(tmp_path / "s")
    assert found.values.shape == (5, 6) and numpy.isfinite(found.values).all()
    # A pixel is the single run from there.
    start = sweep.member(tmp_path / "s", int(found.first[4, 1]))
    words = [w for name, x in start.items() for w in ("--start", f"{name[:-3]}={x!r}")]
    run = pkgen("run", model, *words, "--until", 1, "--method", "rk4", "--step", 0.01,
                "--set", "m1=2", "--record", "theta2")  # fmt: skip
    rows = [float(line.split(",")[1]) for line in run.stdout.splitlines()[1:]]
    assert found.values[4, 1] == max(rows)
