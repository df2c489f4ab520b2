"""What all tests share: where things are, and the command line as a user meets it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from datetime import date
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

import durations
import pytest

from bench.exports import hosted
from pkgen.run import build
from pkgen.system import addons, toolchain
from pkgen.system.exits import BuildError

ROOT = Path(__file__).resolve().parent
os.environ.setdefault("PKGEN_SEEDS_DATE", date.today().isoformat())  # workers have it too
PAGES = sorted([ROOT / "README.md", *ROOT.glob("docs/**/*.md"), *ROOT.glob("addons/*/*.md")])
MODELS = sorted((ROOT / "models").glob("*.lag"))
HOSTED = hosted()
SHOWN = [  # models that live pages run: they refuse sample blocks
    path
    for path in sorted((ROOT / "models").rglob("*.lag"))
    if "\nsample " not in path.read_text("utf-8")
]
STRICT = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wdouble-promotion",
    "-Wshadow",
    "-Werror",
]  # for C that is generated


def pytest_configure(config: pytest.Config) -> None:
    """Compiles the runtime before the first test, so that no test sees the message about it.

    A shell starts what it puts in the background without SIGINT, which programs inherit.
    Results alone are compared, so -O1 is enough; of the long tests those of the first three
    shards of twelve have the flags of users.
    """
    shard = int((config.getoption("--shard") or "1").partition("/")[0])
    if "not long" in config.getoption("markexpr") or shard > 3:
        os.environ.setdefault("CFLAGS", "-O1")
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(Names(config))
        with suppress(BuildError):
            build.runtime_library(toolchain.find_toolchain())


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--shard", metavar="K/N", help="the Kth of N parts of the long tests")


@pytest.hookimpl(tryfirst=True)  # before -m chooses
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Marks what takes longer than `make test` has time for; keeps one shard of the long tests.

    Shards run a third of long tables each day, `-m long` alone runs all.
    """
    store = durations.read()
    seeded = {item.nodeid for item in items if item.get_closest_marker("seeded")}
    long = durations.slow([item.nodeid for item in items], seeded, store)
    for item in items:
        if item.nodeid in long:
            item.add_marker(pytest.mark.long)
        if item.path.is_relative_to(ROOT / "addons"):
            item.add_marker(pytest.mark.needs_addon)
        for name in (name for mark in item.iter_markers("needs_addon") for name in mark.args):
            if find_spec(f"pkgen_{name}") is None:
                item.add_marker(pytest.mark.skip(reason=f"the add-on {name} is not here"))
    if shard := config.getoption("--shard"):
        day = date.fromisoformat(os.environ["PKGEN_SEEDS_DATE"]).toordinal()
        slow = [item for item in items if item.get_closest_marker("long")]
        turn = durations.of_day([item.nodeid for item in slow], day)
        slow = [item for item in slow if item.nodeid in turn]
        marks = [(item.nodeid, item.get_closest_marker("xdist_group")) for item in slow]
        groups = {name: mark.args[0] if mark else name for name, mark in marks}
        kept = durations.shard(groups, store, *map(int, shard.split("/")))
        config.hook.pytest_deselected(items=[item for item in items if item.nodeid not in kept])
        items[:] = [item for item in items if item.nodeid in kept]


class Names:
    """Says the name of each test that fails as it fails, since -q prints letters alone."""

    def __init__(self, config: pytest.Config):
        self.config = config

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            terminal = self.config.pluginmanager.getplugin("terminalreporter")
            day = f", PKGEN_SEEDS_DATE={os.environ['PKGEN_SEEDS_DATE']}" * ("[day" in report.nodeid)
            terminal.write(f"\nFAILED {report.nodeid} ({report.when}{day})\n")


def gone() -> set[str]:
    """The packages of add-ons that pkgen names and that are not here."""
    found = [point for kind in addons.KINDS for point in addons.points(kind).values()]
    return {point.value.partition(".")[0] for point in found if addons.missing(point)}


def no_page() -> str:
    """Returns the line of `chart` and `stability` if the add-on that writes pages is missing."""
    where = addons.missing(addons.points("pages").get("chart"))
    return f"pkgen: no page: it is {where}\n" if where else ""


def seeds(fixed: Iterable[int], turning: int = 0, late: Iterable[int] = ()) -> list:
    """Seeds of a random test: the first three of `fixed` are quick, the others are long.

    `late` once found an error. `turning` seeds follow that are others each day. A failure shows
    them, and PKGEN_SEEDS_DATE, as in 2026-11-29, has those of a day again.
    """
    fixed = list(fixed)
    found = [pytest.param(seed, marks=pytest.mark.seeded, id=str(seed)) for seed in fixed[:3]]
    found += [pytest.param(seed, marks=pytest.mark.long) for seed in (*fixed[3:], *late)]
    day = 1000 * date.fromisoformat(os.environ["PKGEN_SEEDS_DATE"]).toordinal()
    turned = [day + k for k in range(turning)]
    return found + [
        pytest.param(seed, marks=pytest.mark.long, id=f"day{k}") for k, seed in enumerate(turned)
    ]


def long_but(kept: Iterable[object], values: Iterable[object]) -> list:
    """Parameters of a test, of which all but `kept` are for `make test-long`."""
    kept = set(kept)
    return [v if v in kept else pytest.param(v, marks=pytest.mark.long) for v in values]


@lru_cache
def _command_server() -> subprocess.Popen[str]:
    command = [sys.executable, ROOT / "tests" / "command_server.py"]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def run_pkgen(
    *arguments: object, cwd: Path | None = None, env: dict[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run the command line in a process of its own; with `env`, in an interpreter of its own."""
    words = list(map(str, arguments))
    if env is not None:
        command = [sys.executable, "-m", "pkgen", *words]
        return subprocess.run(
            command, capture_output=True, text=True, timeout=2400, cwd=cwd, env=env
        )
    server = _command_server()
    with tempfile.TemporaryDirectory() as directory:
        out, err = Path(directory, "out"), Path(directory, "err")
        request = {
            "arguments": words,
            "cwd": str(cwd or Path.cwd()),
            "env": dict(os.environ),
            "out": str(out),
            "err": str(err),
        }
        server.stdin.write(json.dumps(request) + "\n")
        server.stdin.flush()
        code = int(server.stdout.readline())
        texts = [path.read_text(encoding="utf-8") for path in (out, err)]
    return subprocess.CompletedProcess(["pkgen", *words], code, *texts)


def ran(*arguments: object, **options) -> subprocess.CompletedProcess[str]:
    """Runs a command that has to succeed."""
    done = run_pkgen(*arguments, **options)
    assert done.returncode == 0, done.stderr
    return done


def diagnosed(
    folder: Path, model: Path | str, what: str, *arguments: object
) -> tuple[dict, str, dict]:
    """The diagnostics of a run with its rows in a file, what it says, and its report."""
    path, rows = written(folder, model) if isinstance(model, str) else model, folder / "rows.csv"
    done = ran("run", path, "--diagnose", what, "-o", rows, *arguments)
    report = json.loads(Path(f"{rows}.json").read_text())["report"]
    return report["diagnostics"], done.stderr, report


@pytest.fixture
def pkgen():
    return run_pkgen


def skip_if_ignored(name: str) -> None:
    """A program that nohup starts ignores SIGHUP, and so do all that it starts."""
    number = getattr(signal, f"SIG{name}")
    if number != signal.SIGKILL and signal.getsignal(number) == signal.SIG_IGN:
        pytest.skip(f"SIG{name} is ignored here, as nohup has it")


def wait_for(happened: Callable[[], object], child: subprocess.Popen | None = None) -> None:
    """Waits, as long as a loaded machine may take; the child does not end before."""
    began = time.monotonic()
    while not happened():
        assert child is None or child.poll() is None, child.stderr and child.stderr.read()
        assert time.monotonic() - began < 300
        time.sleep(0.02)


def written(folder: Path, text: str) -> Path:
    """The model in a file of its name."""
    path = folder / f"{text.split()[1]}.lag"
    path.write_text(text, encoding="utf-8")
    return path


def case(name: str) -> str:
    """The text of a model that tests are about."""
    return (ROOT / "tests" / "cases" / f"{name}.lag").read_text(encoding="utf-8")


def expanded(text: str, word: str, form: str) -> str:
    """The text with WORD(s) replaced by a form of s, whatever brackets s has."""
    while f"{word}(" in text:
        first = text.index(f"{word}(")
        start = end = first + len(word) + 1
        depth = 1
        while depth:
            depth += {"(": 1, ")": -1}.get(text[end], 0)
            end += 1
        text = text[:first] + form.format(text[start : end - 1]) + text[end:]
    return text


def table(text: str) -> tuple[list[str], list[list[float]]]:
    """The head and the rows of what a run has printed."""
    head, *lines = text.splitlines()
    return head.split(","), [[float(x) for x in line.split(",")] for line in lines]


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str], Path]:
    return lambda text: written(tmp_path, text)


def rows(pkgen, *arguments: object) -> list[dict[str, float]]:
    """What a run prints, a row by the names of its columns."""
    done = pkgen("run", *arguments)
    assert done.returncode == 0, done.stderr
    names, numbers = table(done.stdout)
    return [dict(zip(names, row, strict=True)) for row in numbers]
