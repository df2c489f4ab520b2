"""The results of models name each model and scene; what they say to try can be tried."""

import json
import math
import os
import re
import shlex
import shutil
from pathlib import Path

import pytest

from conftest import ROOT, ran

TEXT = (ROOT / "docs/dev/results/models.md").read_text(encoding="utf-8")
PAGE, _, TABLE = TEXT.partition("## All of them")
MODELS = sorted((ROOT / "models").rglob("*.lag"))
TRIES = re.findall(r"^Try `pkgen ([^`]*)`", PAGE, re.M)
# Of two masses with the frequencies 1 and sqrt 2, up to t = 7.
HALF_TURNS = [(1, 0.5**0.5), (1, 1), (2, 0.5**0.5), (2, 1), (3, 0.5**0.5)]


def test_each_model_has_its_place_on_the_page() -> None:
    folder, named = "", set()
    for file in re.findall(r"`([\w/]+\.lag)`", "\n".join(re.findall(r"^##+ .*$", PAGE, re.M))):
        # In `chains/a.lag`, `b.lag` the folder of the first is that of the second.
        folder = file.rpartition("/")[0] or folder
        both = [p for p in (Path(file), Path(folder, file)) if (ROOT / "models" / p).exists()]
        assert both, file
        named.add(both[0].as_posix())
    assert named == {p.relative_to(ROOT / "models").as_posix() for p in MODELS}


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_each_scene_is_in_the_table(path: Path) -> None:
    for name in re.findall(r"^scene (\w+)", path.read_text(encoding="utf-8"), re.M):
        row = re.search(rf"^\| {path.stem} +\| +{name} \|.*$", TABLE, re.M)
        assert row, f"{path.stem} {name}: run python -m bench systems --docs"
        met, asked = re.search(r"\| +(\d+) of (\d+) \|", row[0] + "| 0 of 0 |").groups()
        assert met == asked


@pytest.mark.parametrize("words", TRIES)
def test_what_the_page_says_to_try(tmp_path: Path, words: str) -> None:
    shutil.copytree(ROOT / "models", tmp_path / "models")
    ran(*shlex.split(words), cwd=tmp_path)
    output = tmp_path / re.search(r"-o (\S+)", words)[1]
    assert len(output.read_text(encoding="utf-8").splitlines()) > 5


def off(pkgen, path: str, scene: str, what: str, *options: str) -> float:
    """By how much the expectation whose text begins so is off, met or not."""
    done = pkgen("run", ROOT / "models" / path, "--scene", scene, "--json", *options)
    (found,) = [
        e for e in json.loads(done.stdout)["expects"] if e["text"].startswith(f"expect {what}")
    ]
    return abs(found["value"] - found["bound"])


def test_the_chain_nears_the_continuum_as_the_square_of_its_spacing(pkgen, tmp_path: Path) -> None:
    rows = ["-o", str(tmp_path / "rows.csv")]
    coarse = off(pkgen, "chains/sine_gordon.lag", "kink", "centre", *rows)
    finer = ["--set", "d=0.05", "--size", "N=799"]
    fine = off(pkgen, "chains/sine_gordon.lag", "kink", "centre", *finer, *rows)
    assert fine > 1e-4 and 3.8 < coarse / fine < 4.2


def test_precession_leaves_the_first_order_by_the_second(pkgen, tmp_path: Path) -> None:
    rows = ["-o", str(tmp_path / "rows.csv")]
    path, scene = "particles/kepler_perturbed.lag", "inverse_cube"
    whole = off(pkgen, path, scene, "sin(", *rows)
    half = off(pkgen, path, scene, "sin(", "--set", "gamma=5e-6", *rows)
    assert half > 1e-9 and 3.8 < whole / half < 4.2
    # Of `power` over kappa^2, by quadrature of the exact turn with mpmath: half of ten orbits.
    for eps, second in (("0.1", -0.3964), ("0.4", -1.0574), ("0.7", 1.3724)):
        found = off(pkgen, path, "power", "sin(", "--set", f"eps={eps}", *rows)
        assert found == pytest.approx(abs(5 * second), rel=0.01)


@pytest.mark.parametrize("size", [2, 3, 5, 6, 7])
def test_polygons_of_bodies(pkgen, tmp_path: Path, size: int) -> None:
    mu = sum(1 / math.sin(math.pi * k / size) for k in range(1, size)) / 4
    path = ROOT / "models/particles/n_body_space.lag"
    command = ["run", path, "--scene", "polygon", "--size", f"N={size}", "-o", tmp_path / "o.csv"]
    for eccentricity in (0, 0.4):
        ran(*command, "--set", f"mu={mu}", "--set", f"e={eccentricity}")
    worse = pkgen(*command, "--set", f"mu={1.0001 * mu}")
    assert worse.returncode == 4 and "r + e*xi" in worse.stderr


@pytest.mark.parametrize(
    ("path", "words", "times"),
    [
        ("chains/beats.lag", ["--until", "7"], [k * math.pi * r for k, r in HALF_TURNS]),
        ("chains/beats.lag", ["--until", "2.2"], []),
        ("particles/kepler.lag", ["--until", "6.5"], [2 * math.pi]),
        ("particles/kepler.lag", ["--until", "6.2"], []),
        ("particles/projectile.lag", ["--scene", "vacuum"], []),
    ],
)
def test_conjugate_points(tmp_path: Path, path: str, words: list, times: list) -> None:
    rows = tmp_path / "rows.csv"
    ran(*("run", ROOT / "models" / path, *words, "--diagnose", "least_action", "-o", rows))
    found = json.loads(Path(f"{rows}.json").read_text())["report"]["diagnostics"]["least_action"]
    assert found["conjugate"] == pytest.approx(times, abs=1e-8)
    assert found["index"] == len(times) and found["minimum"] == (not times)


def test_a_hundred_thousand_pendulums_keep_their_area_while_they_resolve_it(
    pkgen, tmp_path: Path
) -> None:
    """Until t = 4700 or so and no longer, by a method whose energies are off by 1e-3."""
    rows = tmp_path / "loop.npy"
    done = pkgen(
        *("run", ROOT / "models/pendulums/pendulum.lag", "--scene", "loop", "--until", "5000"),
        *("--method", "verlet", "--step", "0.1", "--every", "100", "--diagnose", "area"),
        *("-o", rows),
        env={**os.environ, "CFLAGS": "-O2"},  # -O1 makes no vectors: ten times as long
    )
    assert done.returncode == 4 and "drift(energy)" in done.stderr
    found = json.loads(Path(f"{rows}.json").read_text())["report"]["diagnostics"]["area"]
    assert found["members"] == 100_000 and found["conserved"]
    assert 3000 <= found["resolved_until"] < 4900
    assert 0 < found["drift"]["max"] <= 1e-12
    areas = [area for t, area, *_ in found["rows"] if t <= found["resolved_until"]]
    assert areas[0] == pytest.approx(-math.pi, rel=1e-14)
    assert max(abs(area + math.pi) for area in areas) <= 1e-12
    assert found["rows"][1][2] < 1e-13 and found["rows"][-1][2] > 1e-12
