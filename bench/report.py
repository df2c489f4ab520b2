"""docs/dev/results/benchmarks.md, written by the run that measured, so that it cannot drift."""

from __future__ import annotations

import re
from pathlib import Path

from .machine import Machine, describe
from .measure import Effort
from .models import ROOT

PAGE = ROOT / "docs/dev/results/benchmarks.md"
# Behind such a mark stands what another command writes: `make bench` leaves it.
MARK = "<!-- python -m bench {} --docs -->\n"
APART = re.compile(MARK.format(r"(\w+)"))
HOW = """# Accuracy against cost

Written by `make bench DOCS=1`; not to be edited. One run, everything interleaved.

**Final error** is that of the state at the end, each component relative to max(1, its size),
against the same equations integrated in `__float128` by an extrapolation method that shares nothing
with pkgen (checked against references of 25 digits). **Times** are of one integration alone, after
compilation and warm-up, medians of at most {rounds} rounds over {starts} starts. **To a final
error**: each method runs at tolerances or steps from loose to tight; between the two that bracket
the error, log time is linear in log error; "≤" where the loosest setting is better already. Ratios
are formed round by round: median [quartiles].

Whoever comes as C source is built by gcc and clang at several flags (`builds.csv`), and its fastest
build takes part, in each model. Parameters are run-time values, except with `heyoka`, which has
them compiled in (`heyoka (par)` has not), and the C++ of mechanicsdsl-core. GSL and CVODE call
pkgen's kernel, compiled into the same file as their right-hand side; "SymPy cse + GSL" calls
SymPy's C. CVODE is that of the wheel scikit-sundae, called from C;
Debian's 6.4.1, rebuilt from source by gcc -O2, took 1.03 to 1.08 times as long (double
pendulum, Adams and BDF, tolerances 1e-6 and 1e-10, in turns, 2026-11-21). PyDy generates right-hand
sides, no methods: it is among the kernels. "pkgen's own C DOP853" is the faster of inlined
and through
function pointers; pkgen's best method is the best of its others. "pkgen gauss (as pkgen
run)" has the compiler and the flags of `pkgen run`, without contraction.
"""


def write_docs(parts: dict[str, str], machine: Machine, effort: Effort) -> None:
    how = HOW.format(rounds=effort.rounds, starts=effort.starts)
    said = "\n".join(machine.lines())
    sections = "\n\n".join(f"## {title}\n\n{text}" for title, text in parts.items())
    _write(f"{how}\n{said}\n\n{sections}\n", _blocks()[1])


def write_block(command: str, text: str) -> None:
    """What that command writes, behind a mark of its own; other blocks stay as they are."""
    own, blocks = _blocks()
    _write(own, {**blocks, command: f"\n{text}"})


def write_table(page: Path, command: str, text: str) -> None:
    """What that command writes, between its two marks in a page of words, with the machine."""
    begin, end = f"<!-- python -m bench {command} --docs -->\n", f"<!-- end of {command} -->\n"
    before, mark, rest = page.read_text(encoding="utf-8").partition(begin)
    if not mark:
        raise SystemExit(f"bench: {page} has no line {begin}")
    here = "; ".join(describe().lines())
    after = rest.partition(end)[2]
    page.write_text(f"{before}{begin}\n{here}.\n\n{text}\n{end}{after}", encoding="utf-8")


def _blocks() -> tuple[str, dict[str, str]]:
    """The page up to the first mark, and what stands behind each."""
    own, *apart = APART.split(PAGE.read_text())
    return own, dict(zip(apart[::2], apart[1::2], strict=True))


def _write(own: str, blocks: dict[str, str]) -> None:
    parts = [f"{MARK.format(command)}\n{text.strip()}\n" for command, text in blocks.items()]
    PAGE.write_text("\n".join([f"{own.rstrip()}\n", *parts]))
