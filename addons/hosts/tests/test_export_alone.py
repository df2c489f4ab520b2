"""A model with one method and no runtime: one C file, firmware, an Arduino library."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest
from columns import RIG

from conftest import HOSTED, ROOT, STRICT, long_but, run_pkgen, table
from pkgen.methods import METHODS

MODELS = HOSTED
PENDULUM = ROOT / "models/double_pendulum.lag"
KEPLER = ROOT / "models/particles/kepler.lag"
FREE = ["-ffp-contract=off", "-fno-math-errno"]


def export(model: Path, host: str, to: Path, *words: object) -> subprocess.CompletedProcess[str]:
    return run_pkgen("export", model, "--as", host, "-o", to, *words)


def rows_of(folder: Path, model: Path, *words: object, flags: list[str]) -> str:
    """What the exported program prints; the file alone is compiled, in a folder of its own."""
    done = export(model, "single", folder / "one.c", *words)
    assert done.returncode == 0, done.stderr
    command = ["gcc", "-std=c99", "-O2", *FREE, *flags, "one.c", "-o", "one", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return subprocess.run([folder / "one"], capture_output=True, text=True, check=True).stdout


def compare(said: str, model: Path, *words: object) -> float:
    """Heads are the same; the largest difference, relative to the largest number there is."""
    run = run_pkgen("run", model, *words)
    assert run.returncode == 0, run.stderr
    (head, rows), (expected, wanted) = table(said), table(run.stdout)
    assert head == expected and len(rows) == len(wanted) > 10
    scale = max(abs(x) for row in wanted for x in row[1:])
    pairs = [zip(a, b, strict=True) for a, b in zip(rows, wanted, strict=True)]
    return max(abs(x - y) for pair in pairs for x, y in pair) / scale


FIXED = [n for n, m in METHODS.items() if m.family in ("ERK", "SPLITTING")]


@pytest.mark.parametrize("method", long_but(["rk4", "verlet", "blanes_moan4"], FIXED))
def test_rows_are_those_of_a_run_to_the_bit(method: str, tmp_path: Path) -> None:
    # A row is 3 steps of 0.3/3, which is not 0.1.
    words = ("--method", method, "--step", "0.1", "--until", "6", "--every", "0.3")
    model = ROOT / "models/coupled_oscillators.lag"
    said = rows_of(tmp_path, model, *words, flags=["-march=native"])
    assert compare(said, model, *words) == 0
    assert compare(said, model, *words[:3], "0.02", *words[4:]) > 0  # it does follow the step


def test_the_page_shows_what_is_printed(tmp_path: Path) -> None:
    page = (ROOT / "addons/hosts/export-single.md").read_text()
    asked, built, shown = re.findall(r"^```\w+\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    words = asked.splitlines()[0].removeprefix("$ pkgen ").split()
    words[1] = str(ROOT / words[1])
    assert run_pkgen(*words, cwd=tmp_path).returncode == 0
    done = subprocess.run(["sh", "-ec", built], cwd=tmp_path, capture_output=True, text=True)
    head, first, *_ = done.stdout.splitlines()
    assert head == shown.splitlines()[0], done.stderr
    row = [float(x) for x in shown.splitlines()[1].split(",")]
    assert [float(x) for x in first.split(",")] == pytest.approx(row, rel=1e-15)


def test_parameters_may_have_any_name(tmp_path: Path) -> None:
    """Those of the arguments of kernels, and of families whose first member stands beside them."""
    names = ("q", "v", "a", "u", "t_", "p", "sc")
    params = "".join(f"param {name} = {k + 2} in (0, inf)\n" for k, name in enumerate(names))
    text = f"model named\n{params}param w[i = 1..2] = 0.5 in (0, inf)\ncoord x\n"
    force = "*".join(names)
    text += f"kinetic x'^2/2\npotential w[1]*w[2]*sin({force}*x/1e3)\nstart x = 1\n"
    (tmp_path / "named.lag").write_text(text)
    words = ("--method", "rk4", "--step", "0.01", "--until", "1", "--every", "0.05")
    words += ("--set", "v=7", "--set", "a=1.5", "--set", "w[1]=0.7", "--set", "w[2]=2")
    said = rows_of(tmp_path, tmp_path / "named.lag", *words, flags=["-march=native"])
    assert compare(said, tmp_path / "named.lag", *words) == 0


PUSHED_RIG = f"""{RIG}scene pushed
  set m = 3, F = -2
  start x' = -0.5, s = -2
end
"""


def test_a_scene_with_inputs_and_states_is_in_it(tmp_path: Path) -> None:
    """To a time that is no multiple of a row."""
    (tmp_path / "rig.lag").write_text(PUSHED_RIG)
    common = ("--method", "rk4", "--step", "1e-3", "--until", "1.03", "--every", "0.05")
    for words in (("--scene", "pushed"), ("--set", "F=-1.5", "--start", "s=-3")):
        said = rows_of(tmp_path, tmp_path / "rig.lag", *words, *common, flags=["-march=native"])
        assert compare(said, tmp_path / "rig.lag", *words, *common) == 0


PUSHED = """#include "rig_step.h"
#include <stdio.h>
int main(void)
{
    struct rig_motion m, n;
    int status = rig_begin(&m, PK_C(0.01)) | rig_begin(&n, PK_C(0.01));
    for (int k = 0; k < 100 && !status; k++) {
        m.u[0] = n.u[0] = PK_C(0.5) * (pk_real)(k % 7);
        status = rig_again(&n) | rig_step(&m) | rig_step(&n);
    }
    printf("%.17g %.17g %.17g", (double)m.q[0], (double)n.q[0], (double)m.t);
    return status;
}
"""


def test_an_input_is_set_at_any_time(tmp_path: Path) -> None:
    """Verlet keeps its last acceleration; of another input it is none."""
    model = tmp_path / "rig.lag"
    model.write_text(PUSHED_RIG.replace("state s\n", "").replace("rate s = x/(1 [m*s])\n", "")
                     .replace(", s = -2", ""))  # fmt: skip
    words = ("--method", "verlet", "--step", "0.01", "--scalar", "double")
    done = export(model, "freestanding", tmp_path / "f", *words)
    assert done.returncode == 0, done.stderr
    (tmp_path / "main.c").write_text(PUSHED)
    sources = [tmp_path / "main.c", *(tmp_path / "f").glob("*.c")]
    command = ["gcc", *FREE, f"-I{tmp_path}/f", *sources, "-o", tmp_path / "main", "-lm"]
    subprocess.run(command, check=True)
    said = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True).stdout
    kept, anew, t = map(float, said.split())
    assert t == 1  # no sum of roundings
    assert kept == pytest.approx(anew, abs=1e-14) and abs(kept - 1) > 0.1


def test_a_tableau_of_ones_own_is_taken(tmp_path: Path) -> None:
    words = ("--composition", "0.3,0.4,0.3", "--method", "composition", "--step", "0.01")
    words += ("--until", "2", "--every", "0.1")
    model = ROOT / "models/coupled_oscillators.lag"
    assert compare(rows_of(tmp_path, model, *words, flags=["-march=native"]), model, *words) == 0


DRAGGED = ROOT / "models/chains/peierls_nabarro.lag"


@pytest.mark.parametrize("model", long_but([DRAGGED, PENDULUM], MODELS), ids=lambda path: path.stem)
def test_every_model_is_that_of_a_run(model: Path, tmp_path: Path) -> None:
    """Without fused multiply-add on both sides, or it is refused for what a step alone is without.
    Families that a run keeps as loops are written out here: other roundings."""
    method = "suzuki4" if model == DRAGGED else ("rk4", "suzuki4")[MODELS.index(model) % 2]
    words = ("--method", method, "--step", "1e-3", "--until", "0.1", "--every", "0.002")
    done = export(model, "single", tmp_path / "one.c", *words)
    if done.returncode == 2:
        why = r"has (constraints|rotations)"
        if method != "rk4":
            why += "|needs the exponential of the forces' rates|needs a system that is separable"
        assert re.search(why, done.stderr), done.stderr
        assert not list(tmp_path.iterdir())
        return
    assert model != DRAGGED
    said = rows_of(tmp_path, model, *words, flags=["-DPK_PORTABLE"])
    loops = json.loads(run_pkgen("describe", model, "--json").stdout)["looped"]
    worst = compare(said, model, *words, "--portable")
    print(model.stem, worst)
    passed = "steps do not end where" in done.stderr  # those of a run end at each knot of a table
    assert worst <= (1e-6 if passed else 1e-13 if loops else 1e-15)


STOPS = """model stops
param w = 3 in (0, inf)
coord x
kinetic x'^2/2
potential w^2*x^2/2
start x = START
start x' = 1
event top: x - 0.3 DIRECTION stop
event turns: x' rising
"""


@pytest.mark.parametrize("direction", ["rising", "falling", ""])
@pytest.mark.parametrize("start", long_but(["0.3", "0.7"], ["0", "0.3", "0.7"]))  # 0.3: upon it
def test_it_ends_at_an_event_that_stops(start: str, direction: str, tmp_path: Path) -> None:
    model = tmp_path / "stops.lag"
    model.write_text(STOPS.replace("START", start).replace("DIRECTION", direction))
    words = ("--method", "rk4", "--step", "0.01", "--until", "4", "--every", "0.02")
    said = rows_of(tmp_path, model, *words, flags=["-march=native"])
    run = run_pkgen("run", model, *words)
    assert "stopped at event top" in run.stderr
    (head, rows), (expected, wanted) = table(said), table(run.stdout)
    assert head == expected and rows[:-1] == wanted[:-1]  # to the bit
    assert rows[-1] == pytest.approx(wanted[-1], abs=1e-13)
    ended = subprocess.run([tmp_path / "one"], capture_output=True, text=True, check=True).stderr
    when = ended.removeprefix("stops: stopped at event top at t = ").strip()
    assert float(when) == rows[-1][0]
    assert "main() ends at: top." in (tmp_path / "one.c").read_text()


def test_a_step_that_ends_upon_an_event_ends_there(tmp_path: Path) -> None:
    """x + 1 = t, to the bit, so that the event's function is zero and has not changed its sign."""
    text = "model m\ncoord x\nkinetic x'^2/2\nstart x = -1, x' = 1\nevent top: x rising stop\n"
    (tmp_path / "m.lag").write_text(text)
    words = ("--method", "euler", "--step", "0.0625", "--until", "2", "--every", "0.0625")
    rows = table(rows_of(tmp_path, tmp_path / "m.lag", *words, flags=[]))[1]
    assert rows[-1][:2] == [1, 0]


ARM = """model arm
param g = 9.81 [m/s^2]
param m = 1 [kg]
gravity [0, -g, 0]
body b mass m inertia [1, 1, 1] at [1, 0, 0] [m]
joint hinge: ground to b revolute [0, 0, 1] coord a limits [-1, 1]
start a = 0.5
"""


def test_it_ends_at_the_limit_of_a_joint(tmp_path: Path) -> None:
    (tmp_path / "arm.lag").write_text(ARM)
    words = ("--method", "rk4", "--step", "0.01", "--until", "4", "--every", "0.02")
    for more in ((), ("--start", "a=-1.1")):  # where it begins beyond it
        said = rows_of(tmp_path, tmp_path / "arm.lag", *words, *more, flags=["-march=native"])
        run = run_pkgen("run", tmp_path / "arm.lag", *words, *more)
        assert "stopped at event hinge_lower" in run.stderr
        rows, wanted = table(said)[1], table(run.stdout)[1]
        assert len(rows) == len(wanted) and rows[:-1] == wanted[:-1]
        assert rows[-1] == pytest.approx(wanted[-1], abs=1e-13)
    done = export(tmp_path / "arm.lag", "freestanding", tmp_path / "f", *words[:4])
    assert "warning: nothing stops at hinge_lower, hinge_upper, where pkgen run does" in done.stderr
    note = "Nothing stops at hinge_lower, hinge_upper, where pkgen run does."
    assert done.returncode == 0 and note in (tmp_path / "f/arm_step.h").read_text()


@pytest.mark.parametrize("host", ["single", "freestanding", "arduino"])
def test_switches_are_warned_of(host: str, tmp_path: Path) -> None:
    text = (
        STOPS.replace("w^2*x^2/2", "w^2*abs(x)")
        .replace(" DIRECTION stop", " falling")
        .replace("DIRECTION", "")
    )
    (tmp_path / "m.lag").write_text(text.replace("START", "1"))
    words = ("--method", "rk4", "--step", "0.01")
    done = export(tmp_path / "m.lag", host, tmp_path / "one", *words)
    assert done.returncode == 0
    assert "warning: steps do not end where step, abs, min or max change" in done.stderr
    files = (tmp_path / "one").rglob("*.[ch]")
    assert sum("Steps do not end" in path.read_text() for path in files) == 1
    assert export(PENDULUM, host, tmp_path / "two", *words).stderr == ""


@pytest.mark.parametrize("host", ["freestanding", "arduino"])
def test_firmware_has_no_double_and_no_libm(host: str, tmp_path: Path) -> None:
    """Compiled as the strictest users do; what it needs of a library is what is said."""
    words = ("--method", "rk4", "--step", "1e-3", "--no-libm")
    done = export(PENDULUM, host, tmp_path / "f", *words)
    assert done.returncode == 0, done.stderr
    sources = sorted((tmp_path / "f").rglob("*.c"))
    assert len(sources) == 2
    command = ["gcc", *STRICT, "-Os", *FREE, "-fno-stack-protector", "-c", *map(str, sources)]
    subprocess.run(command, cwd=tmp_path, check=True)
    said = subprocess.run(
        ["nm", "-u", *map(str, tmp_path.glob("*.o"))], capture_output=True, text=True, check=True
    ).stdout
    needed = set(re.findall(r"U (\w+)", said))
    assert {n for n in needed if not n.startswith("double_pendulum_")} <= {"memcpy", "memset"}


def test_a_sketch_of_states_alone_shows_the_first(tmp_path: Path) -> None:
    (tmp_path / "m.lag").write_text("model m\nstate x [m]\nrate x = -x/(1 [s])\nstart x = 1\n")
    words = ("--method", "rk4", "--step", "0.01")
    assert export(tmp_path / "m.lag", "arduino", tmp_path / "a", *words).returncode == 0
    sketch = (tmp_path / "a/examples/m/m.ino").read_text()
    assert "Serial.println(motion.v[0], 4);" in sketch and "Prints t and x to" in sketch


WRONG = [
    (PENDULUM, ("--step", "1e-3"), "the method gauss is not one of fixed explicit steps"),
    (PENDULUM, ("--method", "verlet", "--step", "1e-3"), "give --method: euler, rk2, rk3, rk4"),
    (PENDULUM, ("--method", "rk4"), "give it by --step H"),
    (ROOT / "models/constrained/pendulum_rod.lag", (), "has constraints"),
    (ROOT / "models/bodies/free_body.lag", (), "has rotations"),
    (PENDULUM, ("--step", "0.003"), "give whole multiples"),
]


@pytest.mark.parametrize(("model", "words", "said"), WRONG)
def test_what_it_has_not_is_said(
    model: Path, words: tuple[str, ...], said: str, tmp_path: Path
) -> None:
    if "--method" not in words and said[:3] != "the":
        words = (*words, "--method", "rk4")
    if "--step" not in words and "--step" not in said:
        words = (*words, "--step", "1e-3")
    done = export(model, "single", tmp_path / "one.c", *words)
    assert done.returncode == 2 and said in done.stderr, done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_motion_that_ends_says_when(tmp_path: Path) -> None:
    """An angle beyond those that firmware is for."""
    words = ("--method", "rk4", "--step", "1e-3", "--until", "1", "--every", "0.1", "--no-libm")
    words += ("--start", "theta1=1530", "--start", "theta1'=9", "--scalar", "float")
    done = export(PENDULUM, "single", tmp_path / "one.c", *words)
    assert done.returncode == 0, done.stderr
    subprocess.run(["gcc", "-O2", *FREE, "one.c", "-o", "one"], cwd=tmp_path, check=True)
    ran = subprocess.run([tmp_path / "one"], capture_output=True, text=True, check=False)
    assert ran.returncode == 4 and "the last valid time is 0." in ran.stderr
