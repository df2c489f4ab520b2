"""What a scene leaves out, as a user meets it: the same motion with and without it."""

from __future__ import annotations

import csv
import json
import math
import subprocess
from pathlib import Path

import pytest

from conftest import STRICT, case, ran

TOP = case("reductions_top")
PAIR = case("reductions_pair")
EXACT = ["--rtol", "1e-13"]


@pytest.fixture(scope="module")
def models(tmp_path_factory) -> Path:
    directory = tmp_path_factory.mktemp("reductions")
    (directory / "top.lag").write_text(TOP)
    (directory / "pair.lag").write_text(PAIR)
    return directory


def rows_of(text: str) -> tuple[list[str], list[list[float]]]:
    head, *rows = list(csv.reader(text.splitlines()))
    return head, [[float(x) for x in row] for row in rows]


def run(pkgen, models: Path, name: str, scene: str, *options: str):
    done = ran("run", models / f"{name}.lag", "--scene", scene, *EXACT, *options)
    return rows_of(done.stdout)


@pytest.mark.parametrize(
    ("name", "scene", "options"),
    [
        ("top", "nods", ["--start", "theta=0.9", "--start", "psi'=8", "--set", "A=1.2"]),
        ("top", "turns", ["--start", "phi=1.5", "--start", "phi'=0.7", "--set", "C=0.5"]),
        ("pair", "both", ["--start", "b'=2"]),
    ],
)
def test_the_motion_is_that_of_the_whole(pkgen, models, name, scene, options):
    head, rows = run(pkgen, models, name, scene, *options)
    again, whole = run(pkgen, models, name, scene, "--no-reduce", *options)
    assert head == again and len(rows) == len(whole) > 8
    for row, other in zip(rows, whole, strict=True):
        assert row == pytest.approx(other, rel=1e-10, abs=1e-10)
    _, plain = run(pkgen, models, name, scene)
    assert max(abs(x - y) for x, y in zip(rows[-1], plain[-1], strict=True)) > 1e-3


def test_what_an_option_adds_is_computed(pkgen, models):
    """--record replaces what the scene records, and what it needs with it."""
    head, rows = run(pkgen, models, "top", "nods", "--record", "psi,height")
    _, whole = run(pkgen, models, "top", "nods", "--record", "psi,height", "--no-reduce")
    assert head == ["t", "psi", "height"]
    assert rows[-1] == pytest.approx(whole[-1], rel=1e-10)


def test_a_start_that_has_no_effect_is_taken_and_one_that_is_held_is_not(pkgen, models):
    _, rows = run(pkgen, models, "top", "nods", "--start", "phi=2")
    assert rows == run(pkgen, models, "top", "nods")[1]
    refused = pkgen("run", models / "pair.lag", "--scene", "led", "--start", "b=2")
    assert refused.returncode == 2 and "the scene holds b" in refused.stderr
    refused = pkgen("run", models / "pair.lag", "--scene", "led", "--start", "c=2")
    assert refused.returncode == 2 and "no such coordinate" in refused.stderr


def test_a_held_motion_is_recorded(pkgen, models):
    head, rows = run(pkgen, models, "pair", "led")
    assert head == ["t", "a", "b", "b'"]
    for t, _, b, rate in rows:
        assert (b, rate) == pytest.approx((0.3 * math.sin(t), 0.3 * math.cos(t)), abs=1e-14)
    assert rows[-1][1] == pytest.approx(run(pkgen, models, "pair", "both")[1][-1][1], rel=1e-10)


def test_columns_asked_for_are_compiled_though_the_scene_records_others(pkgen, models):
    """Momenta, energies and claims too, which no run has of itself; and what is held."""
    asked = ("top", "nods", "--record", "p_psi,V,axial,theta")
    head, rows = run(pkgen, models, *asked)
    assert head == ["t", "p_psi", "V", "axial", "theta"]
    spin = 0.45 * (11 + 0.4 * math.cos(0.7))
    _, all_kept = run(pkgen, models, *asked, "--no-reduce")
    for (_, *row), (_, *whole) in zip(rows, all_kept, strict=True):
        assert row == pytest.approx(whole, rel=1e-9)
        assert row[:3] == pytest.approx([spin, 9.81 * math.cos(row[3]), spin], rel=1e-9)
    assert rows[0][4] != rows[-1][4]
    head, rows = run(pkgen, models, "pair", "led", "--record", "b',p_a")
    assert head == ["t", "b'", "p_a"] and rows[0][1:] == [pytest.approx(0.3), 0]
    for name in ("p_b", "p_a'", "T'", "1+"):
        done = pkgen("run", models / "pair.lag", "--scene", "led", "--record", name)
        assert done.returncode == 2 and f"--record {name}: " in done.stderr


def test_each_reduction_can_be_switched_off_by_name(pkgen, models, tmp_path):
    found = {}
    for off in ("", "cyclic", "fold"):
        path = tmp_path / f"{off or 'all'}.csv"
        options = [f"--no-reduce={off}"] if off else []
        done = ran("run", models / "top.lag", "--scene", "nods", *options, "-o", path)
        found[off] = json.loads(path.with_name(path.name + ".json").read_text())["report"]
    assert found[""]["evaluations"] < found["cyclic"]["evaluations"]
    done = pkgen("run", models / "top.lag", "--scene", "nods", "--no-reduce=cyclc")
    assert done.returncode == 2 and "did you mean 'cyclic'?" in done.stderr


def test_blocks_take_steps_of_their_own(pkgen, models):
    done = pkgen("run", models / "pair.lag", "--scene", "both", "--json")
    a, b = json.loads(done.stdout)["report"]["parts"]
    assert (a["coordinates"], b["coordinates"]) == (["a"], ["b"])
    assert 5 * a["steps"] < b["steps"]
    _, rows = run(pkgen, models, "pair", "sum_of_both")
    assert rows[-1] == pytest.approx(
        run(pkgen, models, "pair", "sum_of_both", "--no-reduce")[1][-1], rel=1e-10
    )


def test_an_accuracy_is_promised_of_each_block(pkgen, models):
    done = pkgen("run", models / "pair.lag", "--scene", "promised")
    assert done.returncode == 0 and done.stderr.count("accuracy 1e-08 of ") == 2
    _, rows = rows_of(done.stdout)
    _, exact = run(pkgen, models, "pair", "promised", "--method", "dop853", "--rtol", "1e-14")
    for k in (1, 2):
        largest = max(abs(row[k]) for row in exact)
        off = max(abs(x[k] - y[k]) for x, y in zip(rows, exact, strict=True))
        assert 0 < off < 1e-8 * largest


USE = """\
#include <stdio.h>
#include "top_nods.h"
#include "top_turns.h"
int main(void)
{
    struct top_nods_params a;
    struct top_turns_params b;
    double q[2], v[2], f[2];
    top_nods_defaults(&a);
    a.start_psi_dot = 8;
    top_nods_derive(&a, NULL);
    if (top_nods_prepare(&a))
        return 1;
    top_nods_start(&a, q, v);
    top_nods_acceleration(&a, 0, q, v, NULL, f);
    printf("%.17g %.17g\\n", a.p_psi, f[0]);
    top_turns_defaults(&b);
    if (top_turns_prepare(&b))
        return 1;
    top_turns_start(&b, q, v);
    top_turns_acceleration(&b, 0, q, v, NULL, f);
    printf("%.17g\\n", f[1]);
    return 0;
}
"""


def test_c_of_two_scenes_links_and_has_no_more_than_they_need(models, tmp_path):
    for scene in ("nods", "turns"):
        ran(models / "top.lag", "--runtime", "--scene", scene, "-o", tmp_path)
    nods, turns = ((tmp_path / f"top_{s}.c").read_text() for s in ("nods", "turns"))
    for kernel in ("mass", "jacobian", "energy", "observe"):
        assert f"void top_nods_{kernel}(" not in nods and f"pk_real top_nods_{kernel}(" not in nods
    assert "top_turns_energy(" in turns and "top_turns_observe(" in turns
    header = (tmp_path / "top_nods.h").read_text()
    assert "phi: p_phi is constant" in header
    assert "    pk_real p_psi; /* constant momentum, follows the starts */\n" in header
    (tmp_path / "use.c").write_text(USE)
    sources = ["use.c", "top_nods.c", "top_turns.c", "-o", "use", "-lm"]
    subprocess.run(["gcc", *STRICT, "-O1", *sources], cwd=tmp_path, check=True)
    out = subprocess.run([tmp_path / "use"], capture_output=True, text=True, check=True).stdout
    p_psi, acceleration, rate = map(float, out.split())
    spin = 8 + 0.4 * math.cos(0.7)
    assert p_psi == pytest.approx(0.45 * spin)
    # A theta'' = A phi'^2 sin cos - p_psi phi' sin + w sin, at the start.
    s, c = math.sin(0.7), math.cos(0.7)
    assert acceleration == pytest.approx((1.3 * 0.16 * s * c - p_psi * 0.4 * s + 9.81 * s) / 1.3)
    assert rate == pytest.approx(0.4)


def test_explain_says_what_each_scene_needs(pkgen, models):
    done = pkgen("explain", models / "top.lag")
    assert "1 of 3 degrees of freedom are left" in done.stdout
    assert "psi: p_psi is constant, of the start" in done.stdout
    scenes = json.loads(pkgen("explain", models / "pair.lag", "--json").stdout)["scenes"]
    said = {scene["name"]: " ".join(scene["lines"]) for scene in scenes}
    assert "a | b: neither moves the other" in said["both"]
    assert "b: its motion is given" in said["led"]


def test_an_angle_whose_rate_varies_faster_than_what_is_left_has_its_share_in_the_steps(
    pkgen, tmp_path: Path
):
    """Of the integral of 1.9/(1 + .9 cos 5t) over ten periods the closed form."""
    model = tmp_path / "hasty.lag"
    model.write_text(
        "model hasty\ncoord z, phi\nkinetic z'^2/2 + phi'^2/2*(1 + 0.9*cos(5*t))\n"
        "potential z^2/2\nstart z = 1, phi' = 1\nscene s\nuntil 4*pi\nmethod gauss rtol 1e-12\n"
        "record z, phi every 4*pi\nexpect phi = 1.9*4*pi/sqrt(0.19) within 1e-9 at 4*pi\n"
        "expect z = 1 within 1e-10 at 4*pi\nend\n"
    )
    done = pkgen("run", model, "--scene", "s")
    assert done.returncode == 0 and "2 of 2 met" in done.stderr, done.stderr
    assert "p_phi kept" not in done.stderr  # which is a parameter now
