"""`python -m bench world [--contacts] [--python PY] [--docs]`: models beside other packages.

PY is a Python that has them (pydy, cython, drake, mujoco, rumoca, scipy); what it cannot import is
said. cases.py has the exact ends, measure.py runs one package, and each package has a file of its
own, with the models as one writes them there. Five models are smooth but for switches; --contacts
takes six of impacts and friction instead, in the folder contacts, by files of the same names.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).resolve().parent.parent.parent / "docs/dev/results/world.md"
MARK, END = "<!-- python -m bench world{} --docs -->\n", "<!-- end -->\n"
PACKAGES = ("pkgen_", "scipy_", "pydy_", "drake_", "mujoco_", "rumoca_")
NAMES = {"scipy_": "SciPy", "pydy_": "PyDy", "drake_": "Drake", "mujoco_": "MuJoCo"}
NAMES |= {"pkgen_": "pkgen", "rumoca_": "Rumoca"}
NOTHING = {
    "PyDy": "its equations have no events; what SciPy does with them is SciPy's",
    "Chrono": "Python's index has no build of it; the pychrono there is about timers",
}
CONTACTS = ("model", "package", "means", "lines", "error", "energy error", "CPU ms", "it does")
HEAD = ("model", "package", "means", "lines", "set-up s", "error", "CPU ms", "at the kink")
# One thread for all; LAPACK's threads would count as CPU time while they wait.
ALONE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def measured(python: str, package: str, model: str) -> dict | str:
    """The result of measure.py, or the reason why there is none."""
    command = [python, "-m", "bench.world.measure", package, model]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **ALONE})
    if done.returncode:
        return (done.stderr.strip().splitlines() or ["?"])[-1]
    return json.loads(done.stdout.splitlines()[-1])


def cells(model: str, name: str, here: dict, exact: list[float]) -> tuple[str, ...]:
    from .cases import error

    errors = {way: f"{error(x['end'], exact):.0e}" for way, x in here["ways"].items()}
    times = {way: _milliseconds(x) for way, x in here["ways"].items()}
    kink = here["kink"]
    if "across" in errors:
        kink += f" ({errors['across']}, {times['across']} ms)"
    return (
        model,
        name,
        here["means"],
        str(here["lines"]),
        f"{here['ways']['default']['setup']:.1g}",
        f"{errors['default']} / {errors['best']}",
        f"{times['default']} / {times['best']}",
        kink,
    )


def contact_cells(model: str, name: str, here: dict, exact: list[float]) -> tuple[str, ...]:
    from .cases import error
    from .contacts.cases import energy_error

    ways = [here["ways"][way] for way in ("default", "best")]
    each = (
        [f"{error(way['end'], exact):.0e}" for way in ways],
        [f"{energy_error(model, way['end'], exact):.0e}" for way in ways],
        map(_milliseconds, ways),
    )
    return (model, name, here["means"], str(here["lines"]), *map(" / ".join, each), here["kink"])


def _milliseconds(way: dict) -> str:
    ms = 1e3 * way["seconds"]
    return f"{ms:.2g}" if ms < 100 else f"{ms:.0f}"


def main(words: list[str]) -> int:
    from .. import machine, tables
    from ..chosen import chosen

    parser = argparse.ArgumentParser(prog="python -m bench world", description=__doc__)
    parser.add_argument("--python", default=sys.executable, help="that of the other packages")
    parser.add_argument("--contacts", action="store_true", help="models of impacts and friction")
    parser.add_argument("--only", default="", help="models whose name has this text")
    parser.add_argument("--docs", action="store_true", help="write docs/dev/results/world.md")
    arguments = parser.parse_args(words)
    here, touch = machine.describe(), arguments.contacts
    part, head, row = ("contacts.", CONTACTS, contact_cells) if touch else ("", HEAD, cells)
    exact_ends = importlib.import_module(f".{part}cases", __package__).EXACT
    rows, versions, calls, missing = [], {}, [], dict(NOTHING) if touch else {}
    for model in chosen(exact_ends, arguments.only, str):
        exact = exact_ends[model]()
        for package in PACKAGES:
            if NAMES[package] in missing:
                continue
            python = sys.executable if package == "pkgen_" else arguments.python
            told = measured(python, part + package, model)
            if isinstance(told, str):
                missing[f"{NAMES[package]}, {model}"] = told
                continue
            versions[package] = told["version"]
            rows.append(row(model, NAMES[package], told, exact))
            calls += [x["call"] for x in told["ways"].values()] if package == "pkgen_" else []
            print(" | ".join(rows[-1]), file=sys.stderr, flush=True)
    text = f"{tables.table(head, rows)}\n\n{'; '.join(here.lines())}\n\n"
    text += f"{', '.join(x for x in versions.values() if x != 'pkgen')}.\n"
    if calls:
        least, most = 1e3 * min(calls), 1e3 * max(calls)
        text += f"A whole call of pkgen's m.run takes {least:.0f} to {most:.0f} ms.\n"
    text += "".join(f"Not measured: {name}: {why}\n" for name, why in missing.items())
    print(text)
    if arguments.docs:
        mark = MARK.format(" --contacts" if touch else "")
        before, _, rest = PAGE.read_text(encoding="utf-8").partition(mark)
        after = rest.partition(END)[2]
        PAGE.write_text(f"{before}{mark}\n{text}\n{END}{after}", encoding="utf-8")
    return 4 if any(name.startswith("pkgen") for name in missing) else 0
