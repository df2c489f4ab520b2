"""`--record` of definitions, `--set` of inputs to functions of t: as a scene has them."""

from __future__ import annotations

import json
import math
import re

import pytest

from conftest import case, table, written
from pkgen import __main__ as command
from pkgen.compiler import compile_model
from pkgen.front.read import read
from pkgen.scenes import compile_plan as scene_use
from pkgen.scenes import options as scene_options

MODEL = case("pulled")
FAMILY = case("beads")


def rows_of(done) -> tuple[str, list[list[float]]]:
    assert done.returncode == 0, done.stderr
    head, rows = table(done.stdout)
    return ",".join(head), rows


@pytest.mark.parametrize("scene", [(), ("--scene", "slow")])
def test_any_definition_is_a_column(pkgen, tmp_path, scene):
    path = written(tmp_path, MODEL)
    asked = "x, y,x' ,r,r',half,stretch',T,p_x,x''"
    done = pkgen("run", path, *scene, "--until", "2", "--every", "1", "--record", asked)
    head, rows = rows_of(done)
    vector = "r.x,r.y,r.z,r.x',r.y',r.z'"
    assert head == f"t,x,y,x',{vector},half,stretch',T,p_x,x''"
    k = 1 if scene else 3
    for _, x, y, vx, rx, ry, rz, ux, _, uz, half, rate, energy, p, ax in rows:
        assert (rx, ry, rz) == pytest.approx((x, y, 0.1 * x)) and ux == vx
        assert uz == pytest.approx(0.1 * vx) and half == pytest.approx(math.hypot(x, y) / 2)
        assert p == pytest.approx(2 * vx) and ax == pytest.approx(-k * x / 2, abs=1e-12)
        assert energy >= vx * vx and math.isfinite(rate)
    assert abs(rows[-1][11]) > 1e-3
    one = pkgen("run", path, *scene, "--until", "1", "--record", "r.y", "--json")
    found = json.loads(one.stdout)
    assert [c["unit"] for c in found["columns"]] == ["s", "m"]


def test_members_of_definitions_are_columns(pkgen, tmp_path):
    path = written(tmp_path, FAMILY)
    run = ("run", path, "--until", "1", "--every", "1", "--record", "w[3],q[3],w[2]',q[2]''")
    for more in ((), ("--size", "N=40")):  # as loops, but for the acceleration
        head, rows = rows_of(pkgen(*run, *more))
        assert head == "t,w[3],q[3],w[2]',q[2]''"
        for t, w, q, rate, a in rows:
            assert w == pytest.approx(3 * q * q) and q == pytest.approx(3 * math.cos(t), abs=1e-9)
            assert rate == pytest.approx(-8 * math.sin(2 * t), abs=1e-8)
            assert a == pytest.approx(-2 * math.cos(t), abs=1e-9)


@pytest.mark.parametrize(
    ("text", "known"),
    [
        ("3*sin(2*t)", lambda t: 3 * math.sin(2 * t)),
        ("3*abs(t - 1)", lambda t: 3 * abs(t - 1)),
        ("m*t/4", lambda t: t / 2),
        ("step(t - 0.7)", lambda t: float(t >= 0.7)),
    ],
)
def test_an_input_is_a_function_of_time_as_in_a_scene(pkgen, tmp_path, text, known):
    """Beside the same in the model's own words."""
    plain = re.sub(r" \[(kg|N/m|m|N)\]", "", MODEL)
    path = written(tmp_path, plain)
    run = ("--until", "2", "--every", "0.5", "--rtol", "1e-13", "--record")
    for scene in ((), ("--scene", "slow", "--set", "k=3")):
        done = pkgen("run", path, *scene, *run, "x,F", "--set", f"F={text}")
        _, rows = rows_of(done)
        for t, _, force in rows:
            assert force == pytest.approx(known(t), abs=1e-14)
    driven = plain.replace("input F\n", f"let F = {text}\n").replace("  set    F = 0\n", "")
    _, same = rows_of(pkgen("run", written(tmp_path, driven), *run, "x,F"))
    assert [r[1] for r in rows] == pytest.approx([r[1] for r in same], abs=1e-11)
    _, still = rows_of(pkgen("run", written(tmp_path, plain), *run, "x"))
    assert abs(still[-1][1] - rows[-1][1]) > 0.05


def test_what_is_wrong_is_shown_as_it_was_given(pkgen, tmp_path):
    path = written(tmp_path, MODEL)
    for options, said in (
        (("--set", "F=3*t"), "set F=3*t"),
        (("--set", "F=x*t"), "'x' is a coordinate: an input cannot use it"),
        (("--set", "m=t*(1 [kg/s])"), "'t' is the time: a scene cannot use it"),
        (("--set", "F=t*(1 [N/s]) +"), "command line: error"),
        (("--set", "G=t"), "command line: error"),
        (("--record", "half''''"), "the rate of an acceleration"),
        (("--record", "half,half"), "is recorded already"),
        (("--record", "hlaf"), "the model has no such column"),
        (("--set", "F=t*(1 [N/s])\nuntil 3"), "one value on one line is needed"),
    ):
        done = pkgen("run", path, *options, cwd=tmp_path)
        assert done.returncode == 2 and said in done.stderr, (options, done.stderr)
        assert "internal" not in done.stderr and "pulled.lag:2" not in done.stderr


def test_charts_and_maps_drive_inputs_too(tmp_path):
    path = written(tmp_path, MODEL)
    for name, scene in (("chart", []), ("stability", ["--scene", "slow"])):
        words = [str(path), *scene, "--set", "F=(1 [N])*sin(t/(1 [s]))", "--set", "k=2"]
        options = command.parser_of(name).parse_args(words)
        made = compile_model(read(str(path)), use=scene_use.whole(options))
        assert not made.equations.inputs and made.structure.autonomous is False
        assert scene_options.numbers(options) == ["k=2"]
