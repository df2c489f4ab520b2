"""What a scene leaves out, as a user meets it: the same motion with and without it."""

from __future__ import annotations

import json
import math
import subprocess
from pathlib import Path

import pytest

from conftest import STRICT, case, ran

TOP = case("reductions_top")
PAIR = case("reductions_pair")


@pytest.fixture(scope="module")
def models(tmp_path_factory) -> Path:
    directory = tmp_path_factory.mktemp("reductions")
    (directory / "top.lag").write_text(TOP)
    (directory / "pair.lag").write_text(PAIR)
    return directory


def test_each_reduction_can_be_switched_off_by_name(models, tmp_path):
    found = {}
    for off in ("", "cyclic", "fold"):
        path = tmp_path / f"{off or 'all'}.csv"
        options = [f"--no-reduce={off}"] if off else []
        ran("run", models / "top.lag", "--scene", "nods", *options, "-o", path)
        found[off] = json.loads(path.with_name(path.name + ".json").read_text())["report"]
    assert found[""]["evaluations"] < found["cyclic"]["evaluations"]


def test_blocks_take_steps_of_their_own(pkgen, models):
    done = pkgen("run", models / "pair.lag", "--scene", "both", "--json")
    a, b = json.loads(done.stdout)["report"]["parts"]
    assert (a["coordinates"], b["coordinates"]) == (["a"], ["b"])
    assert 5 * a["steps"] < b["steps"]


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
