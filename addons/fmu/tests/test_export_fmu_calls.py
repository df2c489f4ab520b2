"""Units that are called, rightly and wrongly: states kept, what is refused, sources."""

from __future__ import annotations

import ctypes
import math
import struct
import subprocess
import zipfile
from pathlib import Path

import pytest
from units import PENDULUM, RIG, Unit, fmpy, method, rig_, unit_  # noqa: F401


@pytest.mark.parametrize("name", ["rk4", "dop853", "gauss"])
def test_states_are_kept_and_serialised(name: str, unit) -> None:
    def made():
        u = Unit(unit(PENDULUM))
        u.fmu.setFloat64([u.by_name["integrator.step"]], [0.01])
        u.fmu.setInt64([u.by_name["integrator.method"]], [method(u.path, name)])
        return u

    u = made().start(l2=0.5)
    u.fmu.doStep(0, 0.5)
    state = u.fmu.getFMUState()
    kept = u.fmu.serializeFMUState(state)
    at = u.get("theta1", "theta2'")
    u.fmu.doStep(0.5, 0.5)
    first = u.get("theta1", "theta2'")
    assert first != at
    u.fmu.setFMUState(state)
    assert u.get("theta1", "theta2'") == at
    u.fmu.doStep(0.5, 0.5)
    assert u.get("theta1", "theta2'") == pytest.approx(first, rel=1e-9)
    other = made().start()  # of other parameters
    again = other.fmu.deserializeFMUState(kept)
    other.fmu.setFMUState(again)
    assert other.get("theta1", "theta2'", "l2") == [*at, 0.5]
    other.fmu.doStep(0.5, 0.5)
    assert other.get("theta1", "theta2'") == pytest.approx(first, rel=1e-9)
    # Of a method that is none, behind two marks, the mode and two times.
    count = len(next(v for v in u.model.modelVariables if v.declaredType).declaredType.items)
    there = kept[40:48]
    assert struct.unpack("d", there)[0] == method(u.path, name) - 1
    unknown = kept[:40] + struct.pack("d", count) + kept[48:]
    spoilt = kept[:20] + b"\xff" * (len(kept) - 20)
    for wrong in (kept[:-1], bytes(len(kept)), b"", spoilt, unknown):
        other.refused(other.fmu.deserializeFMUState, wrong)
    u.fmu.freeFMUState(state)
    other.fmu.freeFMUState(again)


def test_bad_use_is_refused_with_a_message(rig) -> None:
    u = rig()
    f64 = u.fmu.setFloat64
    m, x, rate = (u.by_name[name] for name in ("m", "x", "der(x')"))
    assert "m = 11 is outside its bounds, from 0 to 10" in u.refused(f64, [m], [11.0])
    assert "not finite" in u.refused(f64, [m], [math.nan])
    assert "cannot be set at all" in u.refused(f64, [rate], [1.0])
    assert "there is no variable 4294967295" in u.refused(f64, [2**32 - 1], [1.0])
    assert "counts differ" in u.refused(f64, [m], [1.0, 2.0])
    assert "instantiated" in u.refused(u.fmu.doStep, 0.0, 0.1)
    assert "no such method" in u.refused(u.fmu.setInt64, [u.by_name["integrator.method"]], [99])
    assert "no enumeration" in u.refused(u.fmu.getInt64, [m])
    assert "no variable is of that type" in u.refused(u.fmu.getBoolean, [m])
    f64([m], [0.0])  # a bound of FMI is closed; the model's is not
    assert "m is outside its bounds" in u.refused(u.fmu.getFloat64, [m])
    f64([m], [2.0])
    u.start()
    u.fmu.doStep(0.0, 0.1)
    assert "but the unit is at t = 0.1" in u.refused(u.fmu.doStep, 0.05, 0.1)
    assert "goes forward" in u.refused(u.fmu.doStep, 0.1, -0.1)
    assert "goes forward" in u.refused(u.fmu.doStep, 0.1, math.inf)
    assert "cannot be set now" in u.refused(f64, [x], [1.0])
    assert "no derivatives by variable" in u.refused(
        u.fmu.getDirectionalDerivative, [rate], [m], [1.0]
    )
    assert "in step mode" in u.refused(u.fmu.enterEventMode)
    u.fmu.terminate()
    assert "terminated" in u.refused(u.fmu.doStep, 0.1, 0.1)
    u.fmu.reset()
    assert u.start().get("x") == [1.0]
    null = u.fmu.fmi3GetFloat64
    assert "null" in u.refused(null, u.fmu.component, None, 1, None, 1)
    u.fmu.freeInstance()


def test_wrong_tokens_and_modes_make_no_unit(rig) -> None:
    u = rig()
    u.fmu.guid = "{another}"
    with pytest.raises(Exception, match="instantiate"):
        u.fmu.instantiate(logMessage=lambda *said: u.said.append(said[3].decode()))
    assert "token" in u.said[-1]


@pytest.mark.parametrize("version", ["3", "2"])
def test_sources_compile_alone_and_declare_what_the_standard_does(
    version: str,
    unit,
    tmp_path: Path,
) -> None:
    with zipfile.ZipFile(unit(RIG, version)) as archive:
        archive.extractall(tmp_path)
    sources = tmp_path / "sources"
    if version == "3":
        text = (sources / "buildDescription.xml").read_text()
    else:
        text = (tmp_path / "modelDescription.xml").read_text()
    files = [str(p.relative_to(sources)) for p in sorted(sources.rglob("*.c"))]
    assert all(f'name="{name}"' in text for name in files)
    flags = ["-std=c11", "-O0", "-fPIC", "-shared", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["gcc", *flags, *files, "-o", "unit.so", "-lm"], cwd=sources, check=True)
    # The standard's own headers in place of ours.
    headers = Path(fmpy.__file__).parent / "c-code"
    ours = [f"-DUNIT_FMI{version}_H", "-include", "stdbool.h", "-include", "stdint.h"]
    theirs = ["-include", headers / f"fmi{version}Functions.h", "-fsyntax-only"]
    subprocess.run(["gcc", *ours, *theirs, f"fmi{version}.c"], cwd=sources, check=True)


BOUND = """model bound
param m = 2 [kg] in (0, 10]
input w [m/s]
coord x [m]
kinetic m/2*x'^2
rolling drive: x' = w
"""


@pytest.mark.long
@pytest.mark.parametrize(
    ("seed", "model", "count"), [*((k, RIG, 100_000) for k in (0, 1, 7)), (6, BOUND, 60_000)]
)
def test_calls_at_random_under_sanitizers(
    seed: int, model: str, count: int, unit, tmp_path: Path
) -> None:
    path = unit(model)
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    files = [*map(str, (tmp_path / "sources").rglob("*.c")), Path(__file__).parent / "fmu_fuzz.c"]
    flags = ["-std=c11", "-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    flags.append("-DUNIT_MOST_STEPS=100000")  # seed 7 and 6 ask for steps of 1e-304
    headers = f"-I{Path(fmpy.__file__).parent / 'c-code'}"
    subprocess.run(["gcc", *flags, headers, *files, "-o", tmp_path / "fuzz", "-lm"], check=True)
    token = fmpy.read_model_description(str(path)).instantiationToken
    said = subprocess.run(
        [tmp_path / "fuzz", str(seed), str(count), token],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert said.returncode == 0, said.stdout + said.stderr
    steps, done, refusals, *_ = (int(word.split()[0]) for word in said.stdout.split(", "))
    assert steps > 100 and done > 10_000 and refusals > 10_000


def test_settings_and_bounds(rig) -> None:
    u = rig()
    u.set(m=10.0, k=7.0, **{"integrator.step": 0.5, "integrator.rtol": 1e-3})
    u.set(k=8.0, **{"integrator.step": 0.0})  # as the model has it: it follows m again
    assert u.get("k", "integrator.step") == [40, 0]
    for name, wrong, said in (
        ("m", 10.5, "outside its bounds"),
        ("integrator.step", -0.1, "step is negative"),
        ("integrator.rtol", 1.0, "not positive and below 1"),
        ("integrator.rtol", 0.0, "not positive and below 1"),
    ):
        assert said in u.refused(u.fmu.setFloat64, [u.by_name[name]], [wrong])
    u.fmu.enterInitializationMode(tolerance=1e-5)
    assert u.get("integrator.rtol") == [1e-3]  # what is set goes before the experiment's
    u = rig()
    u.fmu.enterInitializationMode(tolerance=1e-5, startTime=2.0)
    u.fmu.exitInitializationMode()
    assert u.get("integrator.rtol", "time") == [1e-5, 2]
    assert "but the unit is at t = 2" in u.refused(u.fmu.doStep, 2.0 + 1e-6, 0.1)
    u = rig()
    assert "not positive" in u.refused(u.fmu.enterInitializationMode, -1.0)


@pytest.mark.long
def test_a_communication_step_has_an_end(rig) -> None:
    """A step of 1 s takes 1e12 steps of the method: the unit stops on its way and says so."""
    u = rig()
    u.fmu.setInt64([u.by_name["integrator.method"]], [method(u.path, "rk4")])
    u.set(**{"integrator.step": 1e-12})
    u.start()
    said = u.refused(u.fmu.doStep, 0.0, 1.0)
    assert "10000000 steps did not reach t = 1" in said and "at t = 9.99" in said
    assert 0.9e-5 < u.get("time")[0] < 1.1e-5


def test_what_a_callback_may_do(rig) -> None:
    """The inputs it is asked for; nothing else of the unit changes within a step."""
    refused: list[str] = []

    def update(env, t, set_requested, get_allowed, finished, may_return, asked, when):
        if t > 0 and not refused:
            refused.append(u.refused(u.fmu.setFloat64, [u.by_name["m"]], [3.0]))
            refused.append(u.refused(u.fmu.doStep, 0.0, 0.1))

    u = rig(intermediateUpdate=update, requiredIntermediateVariables=[2 << 20])
    u.start()
    u.fmu.doStep(0.0, 0.1)
    assert "cannot be set now" in refused[0] and "within a callback" in refused[1]


def test_steps_are_the_importers_where_none_is_set(rig) -> None:
    """rk4 in steps of other lengths, against the same lengths set as its step."""
    ends = []
    for lengths in ([0.1, 0.2, 0.2], [0.1] * 5):
        for step in (0.0, 0.1):
            u = rig()
            u.fmu.setInt64([u.by_name["integrator.method"]], [method(u.path, "rk4")])
            u.set(**{"integrator.step": step})
            u.start()
            t = 0.0
            for h in lengths:
                u.fmu.doStep(t, h)
                t += h
            ends.append(u.get("x")[0])
    assert abs(ends[0] - ends[1]) > 1e-6 and ends[1:] == pytest.approx([ends[1]] * 3, abs=1e-15)


def test_states_are_written_over_and_are_of_one_model(rig, unit) -> None:
    u = rig().start(x=3.0)
    state = u.fmu.getFMUState()
    u.fmu.doStep(0.0, 0.5)
    there = u.get("x")
    u.fmu.fmi3GetFMUState(u.fmu.component, ctypes.byref(state))
    u.fmu.doStep(0.5, 0.5)
    assert u.get("x") != there
    u.fmu.setFMUState(state)
    assert u.get("x") == there
    u.fmu.terminate()
    state = u.fmu.getFMUState()
    kept = u.fmu.serializeFMUState(state)
    again = rig()
    again.fmu.setFMUState(again.fmu.deserializeFMUState(kept))
    assert "terminated" in again.refused(again.fmu.doStep, 0.5, 0.1)
    other = Unit(unit(RIG, "3", "--start", "x=0.7"))
    assert "no state of this model" in other.refused(other.fmu.deserializeFMUState, kept)
