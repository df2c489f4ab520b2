"""200 kills at random moments of runs by each family of methods: rows are to the byte those of a
run that nobody stopped.

`make test-long`; with PKGEN_UPDATE=1 the table is written to docs/dev/checkpoints.md. The runs are
those of programs, which start in milliseconds.
"""

import contextlib
import os
import random
import signal
import subprocess
import time
from pathlib import Path

import checkpoint_runs as runs
import pytest

from conftest import ROOT

pytestmark = pytest.mark.long

KILLS = 100
SIGNALS = (signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGUSR1)
LEFT = 75
# A model, methods of one family, and seconds that some of them take.
CASES = {
    "explicit Runge-Kutta": ("damped", "rk4", "--step", "1e-4"),
    "adaptive Runge-Kutta": ("damped", "dop853", "--rtol", "1e-11"),
    "splitting": ("free", "blanes_moan6", "--step", "1e-3"),
    "splitting, a chain in one pass": ("chain", "verlet", "--step", "2e-3"),
    "Boris": ("linear", "boris4", "--step", "1e-3"),
    "respa": ("fast", "respa", "--step", "1e-2"),
    "adaptive Verlet": ("free", "adaptive_verlet", "--step", "1e-3"),
    "Gauss, Newton": ("damped", "gauss3", "--step", "1e-2"),
    "Gauss, lanes": ("free", "gauss", "--rtol", "1e-12"),
    "Radau": ("damped", "radau", "--rtol", "1e-8"),
    "Lobatto": ("bound", "lobatto3", "--step", "1e-2"),
    "exponential": ("affine", "exponential", "--step", "1e-2"),
    "constrained": ("rods", "gauss4", "--step", "1e-2"),
    "RATTLE": ("rods", "rattle4", "--step", "5e-3"),
    "rotations, Lie midpoint": ("turning", "lie_midpoint4", "--step", "1e-2"),
    "rotations, RKMK": ("turning", "rkmk8", "--step", "1e-2"),
    "GSL": ("damped", "gsl_rk8pd", "--rtol", "1e-10"),
    "events": ("events", "dop853", "--rtol", "1e-11"),
    "switches": ("switched", "gauss2", "--step", "5e-3"),
    "impulses": ("struck", "dopri5", "--rtol", "1e-9"),
    "short forces": ("short", "dop853", "--rtol", "1e-11"),
    "an ensemble": ("events", "dop853", "--rtol", "1e-10", "--ensemble", "table.csv"),
}
PAGE = ROOT / "docs/dev/checkpoints.md"
INTRODUCTION = f"""\
`make test-long` kills a program of each family {KILLS} times and more, at random moments, half
of the times by SIGKILL, else by SIGTERM or SIGUSR1, and resumes it until it arrives, and so again.
Its rows are then to the byte those of a run that nobody stopped, whose number of steps is given.
`make test` leaves runs of all methods after random numbers of steps.

| family | model, method | kills | by SIGKILL | arrived | steps | bytes that differ |
|---|---|---|---|---|---|---|
"""


@pytest.fixture(scope="module")
def page():
    lines: list[str] = []
    yield lines
    if os.environ.get("PKGEN_UPDATE"):
        before = PAGE.read_text(encoding="utf-8").partition("## Tried")[0]
        table = INTRODUCTION + "\n".join(lines)
        PAGE.write_text(f"{before}## Tried\n\n{table}\n", encoding="utf-8")


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory):
    from pkgen.__main__ import main

    folder = tmp_path_factory.mktemp("programs")

    def built(name: str, *how: str) -> Path:
        model, program = folder / f"{name}.lag", folder / f"{name}-{how[1]}"
        scene = f"scene s\n  until 20\n  method {how[1]} {how[2][2:]} {how[3]}\nend\n"
        model.write_text(runs.text(name) + scene)
        made = ["build", str(model), "--scene", "s", "-o", str(program), "--gsl"]
        assert main(made) == 0
        return program

    return built


def undisturbed(command: list[str], folder: Path) -> tuple[float, int, bytes]:
    """A duration that takes a good second, its steps and rows."""
    until = 20.0
    while True:
        began = time.monotonic()
        done = subprocess.run(
            [*command, "--until", str(until), "-o", "a.csv"], cwd=folder, capture_output=True
        )
        took = time.monotonic() - began
        assert done.returncode == 0, done.stderr
        if took > 0.7 or until > 1e7:
            said = done.stderr.decode().partition("after steps: ")[2].partition(",")[0]
            steps = int(said or 0)  # an ensemble does not say
            return until, steps, (folder / "a.csv").read_bytes()
        until *= max(2, min(50, 1 / took))


@pytest.mark.parametrize("family", CASES)
def test_a_hundred_kills(family: str, programs, page: list[str], tmp_path: Path) -> None:
    name, method, *words = CASES[family]
    dice = random.Random(family)
    with open(tmp_path / "table.csv", "w") as file:
        file.write("y,x'\n" + "".join(f"{k / 9000},0.3\n" for k in range(2000)))
    how = ["--method", method, *words[:2]]
    command = [str(programs(name, *how)), *how, *words[2:]]
    if "--ensemble" in words:
        command += ["--every", "1000"]
    until, steps, rows = undisturbed(command, tmp_path)
    words = ["--until", str(until), "-o", "b.csv", "--checkpoint", "c"]
    command += [*words, "--checkpoint-every", "0.002"]
    kills = killed = arrived = 0
    while kills < KILLS or not arrived:
        more = ["--resume"] if (tmp_path / "c").exists() else []
        process = subprocess.Popen(command + more, cwd=tmp_path, stderr=subprocess.PIPE)
        number = dice.choice(SIGNALS)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(dice.uniform(0.002, 0.06))
        process.send_signal(number)
        said = process.communicate()[1].decode()
        if process.returncode == 0:
            arrived += 1
            assert (tmp_path / "b.csv").read_bytes() == rows
            assert not (tmp_path / "c").exists() and not (tmp_path / "b.csv.partial").exists()
            (tmp_path / "b.csv").unlink()
            continue
        # One that has not yet begun knows nothing of signals.
        assert process.returncode in (LEFT, -number), said
        kills += 1
        killed += process.returncode == -signal.SIGKILL
    page.append(f"| {family} | {name}, {method} | {kills} | {killed} | {arrived} | {steps:,} | 0 |")
