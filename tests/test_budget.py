"""The size of each area, in lines and in tokens of code. Lowering a row is free; raising one asks
for a line that says what it bought."""

import io
import re
import subprocess
import tokenize
from pathlib import Path

import pytest

from conftest import ROOT, gone

BUDGET = {  # area: lines, tokens
    # 48: forces at points, conditions, integrals, first degree, hamiltonian; then tables (950
    # lines), sample blocks (800), parts (540), closed forms, elliptic functions and consistent
    # starts (610). Then 1,590 lines went elsewhere: 150 are left of what 48 may not add.
    # 49: values after events, contacts, friction, modes (920), noise (420).
    # 50: equilibria, modes and symmetries in NumPy (1,000), linear models (430), text and data
    # (150), kernels by inputs and parameters (100); their search in C went (1,610).
    # Then the effective potential (180); derivatives of runs (550). Linear models: an add-on.
    # 51: loops of vectors written as text (880), for an assembly in C (370) that every file had:
    # C of FPUT 249 lines for 890, calls four times as quick; tables, forces at points of families;
    # their sample blocks and values after events (130), one interface for what runs ask (70)
    # constants proved for every length, by sums over members, in place of two short families (270)
    # 52: Taylor coefficients of a motion to any order (320); in a loop over the orders where that
    # is faster, of members in vectors, at kinks, for the method taylor (360)
    "generator": (68_360, 546_000),
    # pieces, tables, samples, nearest starts, events that jump; impacts (950), noise (430); then
    # exponents of motions with impacts (290), kinks of gaps and grazes (60)
    # 50: derivatives of runs: tape, forward, backward, by differences (850); adjoints of implicit
    # methods (280): gradients by the default method cost a few runs, for any number of names
    # 51: families by tables (members*.h, 1,640), in place of 2,100 lines of templates and Python;
    # stiff families by a third of the factorisations, their solution by a third of the time (30)
    # rates given by an event are projected onto constraints (20)
    # 52: the method taylor (190), for members in lanes (190): half the time of gauss and dop853
    # at 1e-8 and below
    "runtime": (35_330, 328_600),
    # continuation (2,050), fits (930), optima (980), CasADi (370), linear models (700)
    "addons": (29_200, 255_000),
    # regimes of rows; arguments of 0, jumps of events; contacts against a reference, noise;
    # contacts mixed with tables, samples, latches, their smooth limit, regimes, billiards
    # equilibria, steady motions and linear models, their plots, effective potentials
    # derivatives of runs (300), the method taylor (120)
    "tests": (55_570, 514_900),
}
# The words for users: README.md and docs, without docs/dev. Forces at points, conditions and H took
# 300, contacts and noise 1,400, tables 400, parts 1,000, sample blocks 800, closed forms and
# consistent starts 700, exponents of billiards and grazes 350, equilibria and linear models 700,
# effective potentials, plots of linear models and a Kalman filter 500, continuation 50,
# derivatives of runs, fits and optima 600.
WORDS = 42_600
CODE = {".py", ".c", ".h", ".j2", ".js", ".css", ".html", ".lark", ".in"}
C_TOKEN = re.compile(r"[A-Za-z_]\w*|\d[\w.]*|\S")
C_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.S)
LAYOUT = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}


def _tokens(path: Path, text: str) -> int:
    if path.suffix != ".py":
        return len(C_TOKEN.findall(C_COMMENT.sub(" ", text)))
    return sum(x.type not in LAYOUT for x in tokenize.generate_tokens(io.StringIO(text).readline))


def _files(area: str) -> list[Path]:
    said = subprocess.run(["git", "ls-files", area], cwd=ROOT, capture_output=True, text=True)
    paths = [ROOT / name for name in said.stdout.splitlines()]
    left = {"vendor", "golden"} | ({"tests"} if area == "addons" else set())
    return [
        p
        for p in paths
        if p.suffix in CODE and p.is_file() and not left & {*p.relative_to(ROOT).parts}
    ]


@pytest.mark.needs_addon
@pytest.mark.parametrize("area", BUDGET)
def test_an_area_is_within_its_budget(area: str) -> None:
    if area == "addons" and gone():
        pytest.skip("not all add-ons are here")
    texts = [(path, path.read_text(encoding="utf-8")) for path in _files(area)]
    lines = sum(text.count("\n") for _, text in texts)
    tokens = sum(_tokens(path, text) for path, text in texts)
    assert lines > 0.97 * BUDGET[area][0], f"{area}: lower its budget to {lines} lines"
    assert lines <= BUDGET[area][0] and tokens <= BUDGET[area][1], (area, lines, tokens)


def test_docs_are_within_their_budget() -> None:
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
    assert sum(len(page.read_text(encoding="utf-8").split()) for page in pages) <= WORDS
