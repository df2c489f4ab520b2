"""However pkgen ends, nothing that it started goes on, and no scratch folder stays."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from conftest import ROOT, skip_if_ignored, wait_for
from pkgen.system import files

HOOP = ROOT / "models/bead_on_hoop.lag"
LATE = 300
RUN = ["run", HOOP, "--method", "gauss4", "--step", "1e-4", "--until", "1e6", "--every", "1"]
ENSEMBLE = ["run", HOOP, "--until", "1e7", "--ensemble", "members.csv", "--threads", "2"]
# A phase: the command, and the file that it then compiles with or has in memory.
LIBRARY = "model.so"
PHASES = {
    "compiling": (["run", HOOP, "--until", "1"], "sleeping_cc"),
    "running": (RUN, LIBRARY),
    "an ensemble": (ENSEMBLE, LIBRARY),
    "a diagnostic": ([*RUN[:5], "1e-3", "--until", "2000", "--diagnose", "lyapunov"], LIBRARY),
    "a chart": (["chart", HOOP, "--seconds", "600"], LIBRARY),
    "a map": (["stability", HOOP, "--points", "400x300"], LIBRARY),
}
SIGNALS = ["INT", "TERM", "HUP", "KILL"]
QUICK = [("compiling", "TERM"), ("compiling", "KILL"), ("running", "HUP"), ("running", "KILL")]
CASES = [
    pytest.param(phase, name, marks=[] if (phase, name) in QUICK else pytest.mark.long)
    for phase in PHASES
    for name in SIGNALS
]
# It starts another process, as gcc starts cc1.
CC = '#!/bin/sh\ncase $* in *-c*) sleep 1000; exit 1;; esac\nexec gcc "$@"\n'


def descendants(pid: int) -> dict[int, str]:
    """Living processes below one, and their command lines."""
    parents, lines = {}, {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            stat = (folder / "stat").read_text().rpartition(")")[2].split()
            lines[int(folder.name)] = (folder / "cmdline").read_text().replace("\0", " ")
        except (OSError, ValueError):
            continue
        if stat[0] != "Z":
            parents[int(folder.name)] = int(stat[1])
    found, new = {}, {pid}
    while new:
        new = {p for p, parent in parents.items() if parent in new} - set(found)
        found |= {p: lines[p] for p in new}
    return found


def loaded(pid: int) -> bool:
    """Whether a process has the library of a model in memory."""
    try:
        return LIBRARY in Path(f"/proc/{pid}/maps").read_text()
    except OSError:
        return False


def alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state not in "ZX"


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks into /proc")
@pytest.mark.parametrize("phase, name", CASES)
def test_no_process_outlives_it(phase: str, name: str, tmp_path: Path) -> None:
    skip_if_ignored(name)
    words, there = PHASES[phase]
    scratch = tmp_path / "tmp"
    scratch.mkdir()
    (tmp_path / "members.csv").write_text("theta\n" + "\n".join(map(str, range(1, 9))) + "\n")
    env = {**os.environ, "TMPDIR": str(scratch)}
    if phase == "compiling":
        compiler = tmp_path / "sleeping_cc"
        compiler.write_text(CC)
        compiler.chmod(0o755)
        env |= {"CC": str(compiler), "PKGEN_CACHE": str(tmp_path / "cache")}
    child = subprocess.Popen(
        [sys.executable, "-m", "pkgen", *map(str, words)],
        env=env,
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )

    def begun() -> bool:
        if child.poll() is not None or there == LIBRARY:
            return child.poll() is not None or loaded(child.pid)
        lines = " ".join(descendants(child.pid).values())
        return there in lines and "sleep 1000" in lines

    wait_for(begun)
    assert child.poll() is None, child.stderr.read()
    time.sleep(0.3)
    started = descendants(child.pid)
    assert started or there == LIBRARY
    child.send_signal(getattr(signal, f"SIG{name}"))
    assert child.wait(timeout=LATE) == (-9 if name == "KILL" else 130)
    wait_for(lambda: not any(map(alive, started)))
    if name != "KILL":
        assert "Traceback" not in child.stderr.read() and not list(scratch.iterdir())
    elif list(scratch.iterdir()):  # the next command takes it away
        done = [sys.executable, "-m", "pkgen", "run", str(HOOP), "--until", "1"]
        subprocess.run(done, env={**os.environ, "TMPDIR": str(scratch)}, capture_output=True)
        assert not list(scratch.iterdir())


def test_only_scratch_of_the_dead_is_removed(tmp_path: Path) -> None:
    """Other folders whose names begin so are people's: bare clones, results, copies of scratch."""

    def marked(name: str, text: str) -> None:
        (tmp_path / name).mkdir()
        (tmp_path / name / "results").write_text("mine")
        (tmp_path / name / files.MARK).write_text(text)

    head, token = files._marked, "0" * 32
    marked("pkgen.dead", f"{head('pkgen.dead')}{token}\n")
    dead = tmp_path / "pkgen.dead"
    stay = {"pkgen.copy": head("pkgen.dead") + token, "pkgen.a": "", "pkgen.b": token}
    stay |= {"pkgen.c": head("pkgen.c"), "pkgen.d": f"{head('pkgen.d')}{token}", "other": ""}
    for name, text in stay.items():
        marked(name, text)
    (tmp_path / "pkgen.git" / "refs").mkdir(parents=True)
    (tmp_path / "pkgen.pipe").mkdir()
    os.mkfifo(tmp_path / "pkgen.pipe" / files.MARK)
    (tmp_path / "pkgen.link").symlink_to(dead)
    before = {p.name for p in tmp_path.iterdir()}
    with files.scratch(tmp_path) as mine:
        files.sweep.cache_clear()
        files.sweep(tmp_path, files.SCRATCH)
        assert {p.name for p in tmp_path.iterdir()} == before - {"pkgen.dead"} | {mine.name}
    assert not mine.exists() and (tmp_path / "pkgen.a/results").read_text() == "mine"


def test_what_nohup_ignores_is_ignored(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "pkgen", *map(str, RUN)]
    child = subprocess.Popen(
        command,
        stdout=subprocess.DEVNULL,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN),
    )
    wait_for(lambda: loaded(child.pid), child)
    child.send_signal(signal.SIGHUP)
    time.sleep(0.3)
    assert child.poll() is None
    child.send_signal(signal.SIGTERM)
    assert child.wait(timeout=LATE) == 130
