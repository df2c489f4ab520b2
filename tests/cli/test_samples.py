"""Sample blocks in runs, ensembles, programs and in Python; what refuses them."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

import pkgen
from conftest import ROOT, case, ran, run_pkgen, table
from pkgen.run.runtime import runtime_library
from pkgen.system.toolchain import RUNTIME, find_toolchain

ARM = ROOT / "models/controlled/two_joint_pid.lag"
MODES = case("sampled_two_modes")


@pytest.fixture
def modes(tmp_path: Path) -> Path:
    path = tmp_path / "modes.lag"
    path.write_text(MODES, encoding="utf-8")
    return path


def exact(until: float, every: float) -> np.ndarray:
    """t, both places, table and mode, by hand: two oscillators, one with held forces."""
    x, v, y, w = 1.0, 0.0, 0.5, 0.0
    table, mode, waiting, now, n, found = 0.0, 0.5, [0.0, 0.0], 0.0, 0, []
    rows = [every * k for k in range(round(until / every) + 1)]
    samples = (0.05 + 0.1 * k for k in range(round(10 * until)))
    for t in sorted({round(t, 9) for t in (*samples, *rows)}):
        middle, cos, sin = (table + (1 if mode == 1 else -1)) / 4, *turn(2, t - now)
        x, v = middle + (x - middle) * cos + v / 2 * sin, v * cos - 2 * (x - middle) * sin
        cos, sin = turn(6**0.5, t - now)
        y, w, now = y * cos + w / 6**0.5 * sin, w * cos - 6**0.5 * y * sin, t
        if abs(t - (0.05 + 0.1 * n)) < 1e-9:
            n, mode = n + 1, 0.5 if mode == 1 else 1
            waiting.append(-y)
            table = waiting.pop(0)
        if min(abs(t - r) for r in rows) < 1e-9:
            found.append([t, x, y, table, mode])
    return np.array(found)


def turn(w: float, t: float) -> tuple[float, float]:
    return float(np.cos(w * t)), float(np.sin(w * t))


@pytest.mark.parametrize(
    "how", [{"method": "gauss", "rtol": 1e-12}, {"method": "rk4", "step": 0.0011}]
)
def test_memory_is_compared_exactly_and_switches_forces(modes: Path, how: dict) -> None:
    columns = ["sample", "memory", "table", "mode"]
    r = pkgen.load(modes).run(1.2, every=0.05, record=columns, **how)
    found, expected = np.array([r.t, *(r[c] for c in columns)]).T, exact(1.2, 0.05)
    assert found == pytest.approx(expected, abs=1e-9)
    assert set(r["mode"]) == {0.5, 1}  # 0.5 == 1 is no more true than that whole numbers are


def test_a_coordinate_that_only_a_block_reads_is_kept(modes: Path) -> None:
    m = pkgen.load(modes)
    whole = m.run(1, method="dop853", rtol=1e-11, every=0.1, record=["sample", "memory"])
    alone = m.run(1, method="dop853", rtol=1e-11, every=0.1, record=["sample"])
    assert alone["sample"] == pytest.approx(whole["sample"], abs=1e-12)


def test_events_jump_with_what_is_held(modes: Path) -> None:
    r = pkgen.load(modes).run(5, method="gauss", rtol=1e-11, every=0.01, record=["table"])
    t, u = r.t, r["table"]
    risen = [b for a, b, x, y in zip(t, t[1:], u, u[1:], strict=False) if x <= 0.2 < y]
    assert r.events["pulls"] == pytest.approx(risen) and risen
    assert r.report["status"] == "PK_STOPPED_EVENT"
    assert r.t[-1] == pytest.approx(r.events["far"][0]) and u[-1] > 0.45 > u[-2]


def test_a_condition_of_memory_begins_at_its_sample(tmp_path: Path) -> None:
    """Of whole numbers k >= 3 and k > 3 begin at two samples."""
    path = tmp_path / "counts.lag"
    path.write_text(
        "model counts\ncoord x\nkinetic x'^2/2\nstart x' = 1\n"
        "sample c every 0.5\nmemory k = 0\nset k = k + 1\nend\n"
        "event three: k >= 3\nevent more: k > 3\nevent neither: not (k < 3)\n"
        "event both: k >= 3 and x > 1.1\n"
        "event whole: floor(x) >= 1\nevent whole_more: floor(3 - x) < 2\n"
    )
    report = json.loads(ran("run", path, "--until", 3, "--json").stdout)["report"]
    met = {e["name"]: e["times"] for e in report["events"]}
    wanted = {"three": 1, "more": 1.5, "neither": 1, "both": 1.1, "whole": 1}
    assert met == {n: [pytest.approx(t, rel=1e-12)] for n, t in wanted.items()} | {
        "whole_more": [pytest.approx(1, rel=1e-12)]
    }


def test_members_are_single_runs(tmp_path: Path) -> None:
    m = pkgen.load(ARM)
    given = {"T": [0.01, 0.013, 0.02], "a": [0.1, -0.3, 0.4], "p1": [150, 80, 160]}
    for how in ({"method": "dop853", "rtol": 1e-10}, {"method": "rk4", "step": 0.003}):
        e = m.ensemble(given, 1, every=0.25, record=["a", "u1", "s2"], **how)
        for k in range(3):
            one = pkgen.load(ARM)
            one.params["T"], one.params["p1"] = given["T"][k], given["p1"][k]
            r = one.run(1, every=0.25, start={"a": given["a"][k]}, record=["a", "u1", "s2"], **how)
            for c in ("a", "u1", "s2"):
                np.testing.assert_array_equal(e.by_member(c)[k], r[c])
    with pytest.raises(pkgen.RunError, match=r"1 of 2 members failed, .*the sample block pid"):
        m.ensemble({"T": [0.01, 1e-30]}, 1, every=1, method="dop853")


def pid(t: float, q: np.ndarray, v: np.ndarray, u: dict[str, float]) -> dict[str, float]:
    e1, e2 = 1 - q[0], 0.5 - q[1]
    w1, w2 = 150 * e1 + 200 * u["s1"] - 25 * v[0], 90 * e2 + 120 * u["s2"] - 12 * v[1]
    found = {"u1": min(max(w1, -45), 45), "u2": min(max(w2, -20), 20)}
    found |= {"s1": u["s1"] + (0.01 * e1 if abs(w1) < 45 else 0)}
    return found | {"s2": u["s2"] + (0.01 * e2 if abs(w2) < 20 else 0)}


def test_a_function_in_place_of_a_block() -> None:
    m = pkgen.load(ARM, "reaches")
    own, other = m.run(2), m.run(2, controllers={"pid": pid})
    for column in own.columns[1:]:
        assert other[column] == pytest.approx(own[column], abs=1e-9)
    still = m.run(2, controllers={"pid": lambda t, q, v, u: {}})
    assert (still["u1"] == 0).all() and still["a"][-1] != own["a"][-1]


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"controllers": {"pdi": pid}}, "did you mean 'pid'"),
        ({"controllers": {"pid": lambda t, q, v, u: {"a": 1}}}, "it has: u1, u2, s1, s2"),
        ({"controllers": {"pid": lambda t, q, v, u: None}}, "returned None: it returns numbers"),
        ({"controllers": {"pid": lambda t, q, v, u: {"u1": "a"}}}, "e.g. {'u': 0.5}"),
        ({"controllers": 3}, "a dictionary of functions by name"),
        ({"inputs": {"u1": 2}}, "the sample block 'pid' sets it"),
        ({"inputs": {"u1": lambda t, q, v: 1}}, "is no input beside a sample block"),
        ({"diagnose": "lyapunov"}, "runs no sample block"),
    ],
)
def test_what_python_refuses(given: dict, says: str) -> None:
    with pytest.raises((pkgen.UsageError, pkgen.ModelError)) as caught:
        pkgen.load(ARM, "reaches").run(1, **given)
    assert says in str(caught.value)


def test_an_exception_of_a_function_ends_the_run() -> None:
    with pytest.raises(ZeroDivisionError):
        pkgen.load(ARM, "reaches").run(1, controllers={"pid": lambda t, q, v, u: 1 / 0})


def test_step_by_step() -> None:
    m = pkgen.load(ARM)
    r = m.run(0.5, method="dop853", rtol=1e-12, every=0.05, record=["a", "u1"])
    it = m.integrator("dop853", rtol=1e-12)
    for k in range(1, 11):
        it.to(k * 0.05)
        assert it.q[0] == pytest.approx(r["a"][k], abs=1e-10)
        assert it.u[0] == pytest.approx(r["u1"][k], abs=1e-7)
    with pytest.raises(pkgen.RunError, match="forward in time"):
        it.to(0.1)


def test_samples_are_cheap() -> None:
    """150 of an arm within 2 ms, where a loop in Python takes seconds."""
    m = pkgen.load(ARM)
    for how in ({"method": "rk4", "step": 0.01}, {"method": "dop853", "rtol": 1e-6}):
        reports = [m.run(1.5, every=1.5, **how).report for _ in range(5)]
        assert min(r["processor"] for r in reports) < 2e-3
        assert 150 <= reports[0]["steps"] < 200  # a step a sample, which begins as long as the last


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("run", "--set", "u1=3"), "--set u1: the sample block 'pid' sets it"),
        (("run", "--set", "u1=(3 [N*m/s])*t"), "'u1' is set by the sample block 'pid'"),
        (("run", "--set", "T=0"), "T is outside its bounds"),
        (
            ("run", "--set", "T=1e-300"),
            "the sample block pid: its period, 1e-300, must be positive",
        ),
        (("run", "--diagnose", "modes"), "'spectrum' and 'area' alone are of its rows"),
        (("stability",), "pkgen stability runs no sample block"),
        pytest.param(("run", "--enclose"), "--enclose runs", marks=pytest.mark.needs_addon),
        pytest.param(("show",), "pkgen show runs", marks=pytest.mark.needs_addon),
        pytest.param(("export", "--as", "fmu"), "export runs", marks=pytest.mark.needs_addon),
        pytest.param(("export", "--as", "single"), "export runs", marks=pytest.mark.needs_addon),
    ],
)
def test_what_is_refused(words: tuple[str, ...], says: str, tmp_path: Path) -> None:
    command, *more = words
    given = ["--scene", "first_half_second"] if command == "run" else []
    output = tmp_path / {"run": "x.csv", "show": "x.html"}.get(command, "x")
    done = run_pkgen(command, ARM, *given, *more, "-o", output)
    assert done.returncode != 0 and says in done.stderr and "Traceback" not in done.stderr


def test_a_program_of_its_own_and_a_swarm(tmp_path: Path) -> None:
    text = ARM.read_text() + "\nscene many\n  swarm k = 1..40\n  start a = k/40\n  until 1 [s]\n"
    text += "  method dop853 rtol 1e-9\n  record a, u1 every 0.5 [s]\nend\n"
    (tmp_path / "arm.lag").write_text(text)
    ran("build", tmp_path / "arm.lag", "-o", tmp_path / "arm")
    words = ["--until", "0.3", "--every", "0.1", "--method", "dop853", "--rtol", "1e-11"]
    said = subprocess.run([tmp_path / "arm", *words], capture_output=True, text=True, check=True)
    own = ran("run", tmp_path / "arm.lag", *words).stdout
    assert np.array(table(said.stdout)[1]) == pytest.approx(np.array(table(own)[1]), abs=1e-10)
    for option, says in (("--set=u1=3", "a sample block sets"), ("--diagnose=lyapunov", "alone")):
        words = [tmp_path / "arm", *option.split("=", 1), "--until", "1", "-o", tmp_path / "x.csv"]
        wrong = subprocess.run(words, capture_output=True, text=True)
        assert wrong.returncode == 2 and says in wrong.stderr
    rows = table(ran("run", tmp_path / "arm.lag", "--scene", "many").stdout)[1]
    assert len(rows) == 120


def test_a_description_has_the_blocks(modes: Path) -> None:
    said = json.loads(ran("describe", modes, "--set", "delay=0.2", "--json").stdout)
    (block,) = said["samples"]
    assert block == {
        "name": "first", "every": 0.2, "offset": 0.05, "delay": 2, "sets": ["table", "mode"],
        "description": "by the other, which no row shows",
    }  # fmt: skip
    assert [u["name"] for u in said["inputs"] if "sampled_by" in u] == [
        "table", "mode", "table.1", "table.2",
    ]  # fmt: skip
    assert (
        "first every delay offset offset delay 2: sets table, mode" in ran("explain", modes).stdout
    )


def test_all_kinds_of_variables_by_two_methods(tmp_path: Path) -> None:
    (tmp_path / "mixture.lag").write_text(case("sampled_mixture"), encoding="utf-8")
    m = pkgen.load(tmp_path / "mixture.lag")
    columns = ["q[1]", "q[4]", "s", "u", "w", "late", "m"]
    whole = m.run(2, method="dop853", rtol=1e-11, every=0.1, record=columns)
    other = m.run(2, method="gauss4", step=0.007, every=0.1, record=columns)
    for column in columns:
        assert other[column] == pytest.approx(whole[column], abs=1e-9)
    k = np.arange(21)
    assert (whole["m"] == 2 + k).all() and (whole["late"] == np.where(k < 2, 0, k)).all()
    held = m.run(0.5, method="gauss", rtol=1e-10, every=0.1, record=["u"], start={"q[2]": 0})
    assert held["u"][0] == pytest.approx(-1)


LOOP = """
#include <stdio.h>
#include <stdlib.h>
#include <pk/pk.h>
#include "two_joint_pid.h"
int main(void)
{
    struct two_joint_pid_params p;
    two_joint_pid_defaults(&p);
    two_joint_pid_prepare(&p);
    pk_real q[2], v[2], u[4] = {0}, end = 0.5;
    two_joint_pid_start(&p, q, v);
    struct pk_constant_input held = {u, 4};
    struct pk_problem problem = {&two_joint_pid_system, &p, pk_constant_input, &held, NULL};
    const struct pk_method *method = pk_method_find("dop853");
    struct pk_options options = pk_options_default();
    options.rtol = 1e-12;
    const size_t size = pk_integrator_size(&problem, method);
    struct pk_integrator it;
    pk_integrator_init(&it, &problem, method, &options, 0, q, v, malloc(size), size);
    struct pk_sampler s = {.system = &two_joint_pid_system, .params = &p, .u = u};
    pk_real *work = malloc(pk_sampler_reals(s.system) * sizeof *work);
    enum pk_status status = pk_sampler_start(&s, &it, end, work);
    while (status == PK_DONE && it.t < end) {
        status = pk_integrator_to(&it, pk_sampler_limit(&s, end));
        if (status == PK_DONE)
            status = pk_sampler_run(&s, &it);
    }
    printf("%d %.10f %.10f\\n", status, it.q[0], it.q[1]);
    return 0;
}
"""


def test_a_loop_of_ones_own_around_the_runtime(tmp_path: Path) -> None:
    ran(ARM, "--runtime", "-o", tmp_path)
    (tmp_path / "main.c").write_text(LOOP)
    library = runtime_library(find_toolchain()) / "libpk.a"
    flags = ["-std=c11", "-Wall", "-Werror", "-DPK_RUNTIME", "-I.", f"-I{RUNTIME}/include"]
    sources = ["main.c", "two_joint_pid.c", library, "-lm"]
    subprocess.run(["gcc", *flags, *sources, "-o", "m"], cwd=tmp_path, check=True)
    said = subprocess.run([tmp_path / "m"], capture_output=True, text=True, check=True).stdout
    assert said == "0 1.0442185145 0.5607034749\n"  # as SciPy has it


def test_every_family_of_methods_begins_anew_at_samples(tmp_path: Path) -> None:
    (tmp_path / "modes.lag").write_text(MODES.replace(" stop", ""), encoding="utf-8")
    m, columns = pkgen.load(tmp_path / "modes.lag"), ["sample", "memory", "table"]
    fixed = [
        "suzuki4",
        "boris4",
        "gauss2",
        "lobatto3",
        "radau5",
        "rattle4",
        "lie_midpoint4",
        "rkmk4",
    ]
    others = ["radau", *(["gsl_msadams", "gsl_msbdf"] if find_toolchain().has_gsl else [])]
    off = {}
    for method in (*fixed, *others):
        how = {"step": 0.003} if method in fixed else {"rtol": 1e-10}
        r = m.run(1.2, method=method, every=0.05, record=columns, **how)
        rows = np.array([r.t, *(r[c] for c in columns)]).T
        off[method] = np.abs(rows - exact(1.2, 0.05)[:, :4]).max()
    assert max(off.values()) < 1e-7, off
