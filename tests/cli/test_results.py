"""What a command leaves in files: the last good result as it was, or the new one whole, each with
what describes it; what is not finished says so in its name and beside it."""

from __future__ import annotations

import json
import os
import re
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy
import pytest

from conftest import ROOT, ran, skip_if_ignored, wait_for, written
from pkgen.system import files
from pkgen.system.exits import UsageError

MODEL = ROOT / "models/bead_on_hoop.lag"
FALL = "model fall\ncoord x\nkinetic x'^2/2\npotential sqrt(x)\nstart x = 1\n"
ENDLESS = ["--method", "gauss4", "--step", "1e-4", "--until", "1e6", "--every", "0.01"]
PKGEN = [sys.executable, "-m", "pkgen"]
LATE = 300  # seconds: for a loaded machine


def start(*words: object, **more: object) -> subprocess.Popen[str]:
    command = [*PKGEN, *map(str, words)]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, **more)


def small_files() -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))


@pytest.fixture
def good(request, tmp_path: Path) -> Path:
    """A result, and what describes it."""
    out = tmp_path / getattr(request, "param", "rows.csv")
    ran("run", MODEL, "--until", "1", "--every", "0.5", "-o", out)
    assert json.loads(files.beside(out).read_text())["partial"] is False
    return out


def seen(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix != ".lag"}


def partial(out: Path, before: dict[str, bytes]) -> dict:
    """The last result is as it was; beside it stands what there is of the new one."""
    now = seen(out.parent)
    assert set(now) - set(before) == {f"{out.name}.partial", f"{out.name}.partial.json"}
    assert {name: now[name] for name in before} == before
    said = json.loads(now[f"{out.name}.partial.json"])
    assert said["partial"] is True and said["data"] == f"{out.name}.partial"
    return said


EARLY = {
    "usage": (["--set", "no=1"], 2),
    "refused": (["--method", "gsl_bsimp", "--every", "1e-9"], 2),
    "no method for it": (["--method", "exponential"], 4),
}


@pytest.mark.parametrize("case", EARLY)
def test_what_fails_before_a_row_leaves_all_as_it_was(pkgen, good: Path, case: str) -> None:
    before = seen(good.parent)
    words, code = EARLY[case]
    done = pkgen("run", MODEL, *words, "-o", good)
    assert done.returncode == code, done.stderr
    assert seen(good.parent) == before


@pytest.mark.parametrize("good", ["rows.csv", "rows.npy"], indirect=True)
def test_what_fails_on_the_way_is_marked(pkgen, good: Path) -> None:
    before = seen(good.parent)
    done = pkgen("run", written(good.parent, FALL), "--every", "0.1", "-o", good)
    assert done.returncode == 4
    said = partial(good, before)
    assert f"pkgen: rows as far as they came: {good}.partial\n" in done.stderr
    assert 1 < said["report"]["last_valid"] < 2
    assert good.suffix == ".csv" or len(numpy.load(f"{good}.partial")) > 5
    # The next good run takes its place, and nothing of it is left.
    ran("run", MODEL, "--until", "2", "--every", "0.5", "-o", good)
    assert set(seen(good.parent)) == {good.name, f"{good.name}.json"}
    assert (
        len(numpy.load(good) if good.suffix == ".npy" else good.read_text().splitlines()[1:]) == 5
    )


def test_a_full_disk(good: Path) -> None:
    before = seen(good.parent)
    words = ["run", MODEL, "--until", "100", "--every", "0.01", "-o", good]
    child = start(*words, preexec_fn=small_files)
    said = child.communicate(timeout=LATE)[1]
    assert child.returncode == 2 and "run: cannot write rows: File too large\n" in said
    partial(good, before)
    assert len((good.parent / "rows.csv.partial").read_bytes()) <= 20_000


PAGE = pytest.param(["explain", MODEL, "--html", "x.html"], marks=pytest.mark.needs_addon("pages"))


@pytest.mark.parametrize("words", [[MODEL, "--canonical", "-o", "."], PAGE], ids=["C", "page"])
def test_sources_and_pages_are_written_all_or_none(words: list, pkgen, tmp_path: Path) -> None:
    assert pkgen(MODEL, "-o", tmp_path).returncode == 0
    before = seen(tmp_path)
    child = start(
        *words,
        cwd=tmp_path,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (5_000, 5_000)),
    )
    said = child.communicate(timeout=LATE)[1]
    assert child.returncode == 2 and said.endswith(": File too large\n") and "\n" not in said[:-1]
    assert seen(tmp_path) == before


ENDS = ["INT", pytest.param("TERM"), pytest.param("HUP", marks=pytest.mark.long), "KILL"]


@pytest.mark.parametrize("name", ENDS)
def test_a_signal_on_the_way(good: Path, name: str) -> None:
    skip_if_ignored(name)
    before = seen(good.parent)
    child = start("run", MODEL, *ENDLESS, "-o", good)
    growing = files.partial(good)
    wait_for(lambda: growing.exists() and growing.stat().st_size > 10_000, child)
    child.send_signal(getattr(signal, f"SIG{name}"))
    code = child.wait(timeout=LATE)
    said = partial(good, before)
    if name == "KILL":
        assert code == -9 and said["report"] == {}
    else:
        assert code == 130 and said["report"]["interrupted"] is True
        head, *table = growing.read_text().splitlines()
        assert all(row.count(",") == head.count(",") for row in table) and len(table) > 10
        assert growing.read_text().endswith("\n")


def test_a_link_is_followed(pkgen, tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    real, link = tmp_path / "there/real.csv", tmp_path / "link.csv"
    real.write_text("old\n")
    real.chmod(0o640)
    link.symlink_to("there/real.csv")
    assert pkgen("run", MODEL, "--until", "1", "-o", link).returncode == 0
    assert link.is_symlink() and real.read_text().startswith("t,theta")
    assert real.stat().st_mode & 0o777 == 0o640 and files.beside(link).exists()
    assert [path.name for path in real.parent.iterdir()] == ["real.csv"]


def test_a_stream_is_written_as_it_comes(tmp_path: Path) -> None:
    pipe, link = tmp_path / "pipe.csv", tmp_path / "out.csv"
    os.mkfifo(pipe)
    reader = subprocess.Popen(["cat", pipe], stdout=subprocess.PIPE, text=True)
    child = start("run", MODEL, "--until", "1", "--every", "0.5", "-o", pipe)
    rows = reader.communicate(timeout=LATE)[0]
    assert child.wait(timeout=LATE) == 0 and len(rows.splitlines()) == 4
    link.symlink_to("/dev/stdout")
    words = ["run", MODEL, "--until", "1", "--every", "0.5", "-o"]
    for out in (link, "-"):
        child = start(*words, out, stdout=subprocess.PIPE, cwd=tmp_path)
        assert child.communicate(timeout=LATE)[0] == rows
    assert {p.name for p in tmp_path.iterdir()} == {"pipe.csv", "pipe.csv.json", "out.csv"} | {
        "out.csv.json"
    }


def test_two_runs_do_not_write_the_same_file(pkgen, tmp_path: Path) -> None:
    with files.Result(tmp_path / "a.csv", "{}\n") as result:
        done = pkgen("run", MODEL, "--until", "1", "-o", tmp_path / "a.csv")
        assert done.returncode == 2 and "another run is writing it" in done.stderr
        result.file.write(b"t\n1\n")
        result.finish("{}\n")
    assert (tmp_path / "a.csv").read_text() == "t\n1\n"


def as_nobody(work: Callable[[], None]) -> int:
    """The exit code of a process that may not write what is root's."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            if os.geteuid() == 0:
                os.setuid(65534)
            work()
            code = 0
        except (PermissionError, UsageError):
            code = 7
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def test_what_is_write_protected_stays(tmp_path: Path) -> None:
    out = tmp_path / "rows.csv"
    out.write_text("kept")
    out.chmod(0o444)
    for folder in (tmp_path, *tmp_path.parents[:3]):
        folder.chmod(0o777 if folder == tmp_path else folder.stat().st_mode | 0o055)
    assert as_nobody(lambda: files.Result(out, "")) == 7
    assert as_nobody(lambda: files.replace({out: "new"})) == 7
    assert as_nobody(lambda: files.replace({tmp_path / "other": "new"})) == 0
    assert out.read_text() == "kept" and {p.name for p in tmp_path.iterdir()} == {
        "rows.csv",
        "other",
    }


def killed_at(last: int) -> None:
    """This process is killed at its so-manieth call that changes a name."""
    count = [0]

    def counted(real: Callable) -> Callable:
        def call(*words: object, **more: object) -> object:
            count[0] += 1
            if count[0] == last:
                os.kill(os.getpid(), signal.SIGKILL)
            return real(*words, **more)

        return call

    for name in ("replace", "unlink", "rename"):
        setattr(os, name, counted(getattr(os, name)))


def test_killed_at_any_step_a_result_is_never_of_two_runs(tmp_path: Path) -> None:
    out = tmp_path / "rows.csv"
    survived = 0
    for last in range(1, 20):
        for path in tmp_path.iterdir():
            path.unlink()
        out.write_text("t\nold\n")
        files.beside(out).write_text("old")
        child = os.fork()
        if child == 0:
            killed_at(last)
            result = files.Result(out, "{}")
            result.file.write(b"t\nnew\n")
            result.finish("new")
            os._exit(0)
        killed = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -9
        beside = files.beside(out)
        data = re.sub(r"^t\n|\n", "", out.read_text())
        described = beside.read_text() if beside.exists() else data
        assert data == described and data in ("old", "new")
        survived += not killed
        if not killed:
            assert data == "new" and beside.exists()
            break
    assert survived == 1


WRITES = re.compile(r"\bopen\([^)]*, \"[wax]b?\"|write_text\(|write_bytes\(|savefig\(|\.save\(")
# Into folders of pkgen's own, which nobody sees before they are whole, or beside, under a name of
# its own until it is whole.
OWN = {"__main__.py", "cli/pictures.py", "cli/run.py", "run/build.py"}
OWN |= {"run/simulate.py", "run/runtime.py", "system/cache.py", "system/files.py"}
OWN |= {"plot/style.py"}  # of pictures
OWN |= {"back/wasm/build.py", "back/library.py"}
OWN |= {"analysis/chart/wide.py"}  # a program that tries a type, in a scratch folder
ADDED = {"pkgen_film/film.py", "pkgen_film/write.py", "pkgen_sweep/store.py"}


@pytest.mark.needs_addon
def test_nothing_else_writes_files() -> None:
    def writers(root: Path, pattern: str) -> set[str]:
        found = (path for path in root.glob(pattern) if WRITES.search(path.read_text()))
        return {path.relative_to(root).as_posix() for path in found}

    assert writers(ROOT / "generator/pkgen", "**/*.py") == OWN
    addons = {root: writers(root, "pkgen_*/**/*.py") for root in (ROOT / "addons").glob("*")}
    assert {path for found in addons.values() for path in found} <= ADDED


@pytest.mark.parametrize("method", ["gauss", "dop853"])
@pytest.mark.parametrize(
    ("potential", "start", "least", "most"),
    [
        ("x^2/2", "x = 0, x' = 1e-3", 0.05, 1),  # the first step, from rest or not, is a guess
        ("x^2/2", "x = 1", 0.05, 1),
        ("x^4/4", "x = 1e-30, x' = 1", 0.05, 1),
        ("-1/(x^2 + 1e-4)^(1/2)", "x = 1", 1e-8, 0.05),  # a passage that is truly short
    ],
)
def test_the_smallest_step_is_one_of_the_method(
    pkgen, write, method: str, potential: str, start: str, least: float, most: float
) -> None:
    text = f"model swing\ncoord x\nkinetic x'^2/2\npotential {potential}\nstart {start}\n"
    words = ("--until", "7.77", "--every", "0.37", "--method", method, "--json", "-o")
    path = write(text)
    done = pkgen("run", path, *words, path.parent / "rows.csv")
    report = json.loads(done.stdout)["report"]
    assert least < report["step_min"] / report["step_max"] <= most
