"""The floor plan: arrows run one way, no circle among files, and few files at each root.

`FLOORS` is docs/dev/architecture.md as data. A folder may use those on floors below its own.
"""

import ast
import json
import re
import subprocess
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import durations
import pytest

from conftest import ROOT, gone
from pkgen.back import runtime
from pkgen.run import runtime as runtime_parts
from pkgen.system import toolchain

PKGEN = ROOT / "generator" / "pkgen"
FLOORS = """
record
system source limits defaults functions version
tree methods
indices
model front
graph own
equations front/check
middle middle/points
middle/expand middle/analyze
middle/particles
middle/derive
middle/reduce middle/families
back back/host
back/c back/wasm
back/c/families
plan
compiler
run
scenes
plot
describe
analysis/chart analysis/linear analysis/sensitivity
analysis/choose analysis/stability explain
api
__init__ cli
__main__
"""
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS.split("\n")) for room in rooms.split()}


def _modules() -> dict[str, Path]:
    found = {}
    for path in sorted(PKGEN.rglob("*.py")):
        parts = path.relative_to(PKGEN.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


MODULES = _modules()


def _imported(name: str) -> Iterator[str]:
    """The modules that a module names in `import`, those for its annotations among them."""
    path = MODULES[name]
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = package.split(".")[: len(package.split(".")) - node.level + 1]
            base = ".".join([*base, node.module] if node.module else base)
            for alias in node.names:
                inner = f"{base}.{alias.name}"
                yield inner if inner in MODULES else base


def _room(name: str) -> str:
    folder = MODULES[name].parent.relative_to(PKGEN)
    return MODULES[name].stem if folder == Path() else folder.as_posix()


def _circle(arrows: Mapping[str, set[str]]) -> list[str]:
    """The files of one circle; empty without any."""
    try:
        TopologicalSorter(arrows).prepare()
    except CycleError as error:
        return error.args[1]
    return []


PYTHON = {name: set(_imported(name)) - {name} for name in MODULES}


def test_a_circle_is_found() -> None:
    assert _circle({"a": {"b"}, "b": {"c"}, "c": {"b"}})
    assert _circle({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == []


def test_no_circle_among_modules() -> None:
    assert _circle(PYTHON) == []


def test_arrows_point_down() -> None:
    wrong = [
        f"{name} -> {target}"
        for name, targets in PYTHON.items()
        for target in targets
        if _room(name) != _room(target) and FLOOR[_room(target)] >= FLOOR[_room(name)]
    ]
    assert wrong == []


def test_every_room_is_used_and_has_a_floor() -> None:
    assert {_room(name) for name in MODULES} <= FLOOR.keys() | {"back", "analysis"}
    assert set(FLOOR) <= {_room(name) for name in MODULES}


# Modules that tell equations of families of any length from those that are written out: what
# derives and writes them, what chooses between both, and what writes their rows as text.
FAMILIES = "middle.families", "back.c.families", "compiler", "explain.families", "explain.rows"


def test_no_other_module_asks_whether_a_model_has_families():
    asking = [
        name
        for name, path in MODULES.items()
        if not name.removeprefix("pkgen.").startswith(FAMILIES)
        and re.search(r"families\.equations|FamilyEquations|NotKept", path.read_text())
    ]
    assert asking == []


C_FLOORS = """
src/core
src/constraints src/explicit src/implicit src/variational
src/integrate
src/events src/method
src/reason
src/subsystems src/watch
src/ensemble src/diagnose
gsl omp
run/base
run/settings
run/observers
run/steps
run/ensemble run/diagnose
run/run run/evaluate run/advance
run/stability
program
"""


@pytest.fixture(scope="module")
def objects(tmp_path_factory: pytest.TempPathFactory) -> dict[str, set[str]]:
    """By each C file of the runtime, those whose functions it calls: the linker's view. Compiled
    here are those that the runtime's libraries are without."""
    source, folder = ROOT / "runtime", tmp_path_factory.mktemp("objects")
    tools = toolchain.find_toolchain()
    library = runtime_parts.runtime_library(tools)
    kept: dict[str, set[str]] = {}
    for top, name in runtime_parts.ARCHIVES.items():
        if (library / name).exists():
            kept.setdefault(name, set()).add(top)
    others = {"program", "gsl"} - {part for parts in kept.values() for part in parts}
    for path in (path for part in others for path in (source / part).rglob("*.c")):
        command = ["gcc", "-c", "-O0", f"-I{source / 'include'}", path]
        subprocess.run([*command, "-o", folder / f"{path.parent.name}_{path.stem}.o"], check=True)
    home, uses = {}, {}
    for head, parts, objects in [("", others, [*folder.iterdir()])] + [
        (f"{name}-", parts, [library / name]) for name, parts in kept.items()
    ]:
        own = {
            f"{head}{path.parent.name}_{path.stem}.o": path.relative_to(source)
            .with_suffix("")
            .as_posix()
            for part in parts
            for path in (source / part).rglob("*.c")
        }
        said = subprocess.run(["nm", "-A", "-g", *objects], capture_output=True, text=True)
        symbols = re.findall(r"([\w.-]+\.o):.* (\w) (\w+)$", said.stdout, re.MULTILINE)
        assert {of for of, _, _ in symbols} == own.keys()
        uses |= {own[of]: {n for o, kind, n in symbols if o == of and kind == "U"} for of in own}
        home |= {name: own[of] for of, kind, name in symbols if kind != "U"}
    return {own: {home[name] for name in used & home.keys()} for own, used in uses.items()}


def test_no_circle_among_c_files(objects: dict[str, set[str]]) -> None:
    assert len(objects) > 100 and _circle(objects) == []


def test_arrows_of_the_runtime_point_down(objects: dict[str, set[str]]) -> None:
    floor = {d: i for i, rooms in enumerate(C_FLOORS.split("\n")) for d in rooms.split()}

    def room(name: str) -> str:
        """The folder of a file, or the file where its folder has several floors."""
        return next(part for part in (name, *map(str, Path(name).parents)) if part in floor)

    wrong = [
        f"{one} -> {other}"
        for one, used in objects.items()
        for other in used
        if room(one) != room(other) and floor[room(other)] >= floor[room(one)]
    ]
    assert wrong == []
    assert {room(name) for name in objects} == set(floor)


@pytest.mark.parametrize(
    ("folder", "pattern", "most"),
    [(PKGEN, "*.py", 14), (ROOT / "runtime/src", "*.c", 12), (ROOT / "runtime/run", "*.c", 4)],
)
def test_few_files_stand_at_the_root(folder: Path, pattern: str, most: int) -> None:
    assert len(list(folder.glob(pattern))) <= most


def test_each_package_says_what_it_is_for() -> None:
    silent = [
        name
        for name, path in MODULES.items()
        if path.name == "__init__.py" and not ast.get_docstring(ast.parse(path.read_text()))
    ]
    assert silent == []


GONE = gone()
HERE = pytest.mark.skipif(bool(GONE), reason="the docs name add-ons")
NAMED = re.compile(
    r"(?<![\w/.*<-])((?:\w+/)*\w+\.py|(?:runtime/)?src/[\w/]+\.[ch]|back/c/[\w/.]+j2)\b"
)


@HERE
@pytest.mark.needs_addon
def test_files_that_comments_and_docs_name_are_there() -> None:
    """By their last folders; PYTHON files anywhere, C files of the runtime's core from src/ on."""
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    files = tracked.stdout.split()
    ends = {"/".join(p.split("/")[i:]) for p in files for i in range(p.count("/") + 1)}
    told = [
        p for p in files if re.match(r"(generator|addons|runtime|docs)/.*\.(py|[chj]2?|md)$", p)
    ]
    astray = {
        f"{path}: {name}"
        for path in told
        for name in NAMED.findall((ROOT / path).read_text(encoding="utf-8"))
        if name not in ends
    }
    assert len(told) > 300 and sorted(astray) == []


PAGE = (ROOT / "docs/dev/architecture.md").read_text(encoding="utf-8")
ROOTS = [
    ROOT / folder
    for folder in (
        *(".", "generator/pkgen", "generator/pkgen/front", "generator/pkgen/back/c"),
        *("runtime", "runtime/src", "runtime/include"),
    )
] + [*ROOT.glob("addons/*")]
PATH = re.compile(r"`([\w.*-]+(?:/[\w.*-]+)+)`")
# A path and the function that is named behind it.
PLACE = re.compile(PATH.pattern + r" `(\w+)`")


def _found(path: str) -> list[Path]:
    return [place for root in ROOTS for place in root.glob(path)]


@pytest.mark.needs_addon
@HERE
def test_what_the_page_names_is_there() -> None:
    paths = set(PATH.findall(PAGE))
    assert len(paths) > 80 and [path for path in paths if not _found(path)] == []


@pytest.mark.needs_addon
@HERE
def test_functions_are_where_the_page_says() -> None:
    places = PLACE.findall(PAGE)
    astray = [
        (path, name)
        for path, name in places
        if not any(re.search(rf"\b{name}\b", place.read_text()) for place in _found(path))
    ]
    assert len(places) > 10 and astray == []


def _with_headers(text: str) -> set[str]:
    """What a C text and the headers that it includes need."""
    found: set[str] = set()
    waiting = [text]
    while waiting:
        for path in {*runtime.needed(waiting.pop())} - found:
            found.add(path)
            if path.endswith(".h"):
                waiting.append((ROOT / "runtime" / path).read_text())
    return found


def test_exports_take_what_a_linker_would(objects: dict[str, set[str]]) -> None:
    """By the text of each C file of the core those that it calls."""
    short = {
        f"{one} -> {other}"
        for one, used in objects.items()
        if one.startswith("src/")
        for other in used - {one}
        if f"{other}.c" not in _with_headers((ROOT / "runtime" / f"{one}.c").read_text())
    }
    assert short == set()


@pytest.mark.needs_addon
def test_the_store_of_durations_names_what_is_there() -> None:
    """A function of another name would have none, and be quick unseen."""
    for path, names in json.loads(durations.STORE.read_text(encoding="utf-8")).items():
        if path.startswith("addons/") and f"pkgen_{path.split('/')[1]}" in GONE:
            continue
        text = (ROOT / path).read_text(encoding="utf-8")
        assert not [name for name in names if f"def {name}(" not in text], path
