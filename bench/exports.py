"""`python -m bench exports [--docs] [--only NAME,...]`: every model to the hosts that run it whole.

A row a model, of each host: kB, seconds to make it, and the largest difference from `pkgen run`
with the same method and step, in units of each column's size (at least 1), over 16 steps. A unit is
validated by FMPy and the standard's schemas first. Exit code 4 if one differs by more than WITHIN.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

from . import machine
from .tables import table

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "exports.md"
MARK = "<!-- python -m bench exports --docs -->\n"
STEP, STEPS = 2.0**-7, 16
WITHIN = 1e-9
METHOD = "rk4"
Rows = dict[str, list[float]]
IN_WHEEL = """
import json, sys
sys.path.insert(0, FOLDER)
import NAME as d
rows = d.Model().run(UNTIL, every=STEP, method="rk4", step=STEP)
print(json.dumps({name: rows[name].tolist() for name in rows.columns}))
"""


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench exports", description=__doc__)
    parser.add_argument("--docs", action="store_true", help="write the table into docs/exports.md")
    parser.add_argument("--only", metavar="LIST", help="these models alone")
    options = parser.parse_args(words)
    only = options.only.split(",") if options.only else None
    rows, wrong = [], []
    for model in sorted((ROOT / "models").rglob("*.lag")):
        if only is not None and model.stem not in only:
            continue
        row: list[object] = [model.stem]
        expected = _run(model)
        for host, (more, result) in HOSTS.items():
            size, seconds, off = _measured(model, more, result, expected)
            row += [size, seconds, off]
            if not off <= WITHIN:
                wrong.append(f"{model.stem}, {host}: {off:.3g}")
        rows.append(row)
        print(" ".join(f"{x:.3g}" if isinstance(x, float) else str(x) for x in row), flush=True)
    for line in wrong:
        print(line, file=sys.stderr)
    if options.docs:
        _write(rows)
    return 4 if wrong else 0


def _measured(
    model: Path, more: list[str], result: Callable[[Path, Path], Rows], expected: Rows
) -> tuple[float, float, float]:
    """kB, seconds, the difference."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        began = time.monotonic()
        _pkgen("export", str(model), *more, "-o", str(folder / "made"))
        seconds = time.monotonic() - began
        (path,) = (folder / "made").iterdir()
        return path.stat().st_size / 1000, seconds, _off(result(path, folder), expected)


def _pkgen(*words: str) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "pkgen", *words], capture_output=True, text=True, cwd=ROOT
    )
    if done.returncode:
        raise RuntimeError(f"pkgen {' '.join(words)}: {done.stderr}")
    return done.stdout


def _run(model: Path) -> Rows:
    words = ("--method", METHOD, "--step", str(STEP), "--until", str(STEP * STEPS))
    head, *lines = _pkgen("run", str(model), *words, "--every", str(STEP)).splitlines()
    columns = zip(*(map(float, line.split(",")) for line in lines), strict=True)
    return {name: list(column) for name, column in zip(head.split(","), columns, strict=True)}


def _off(found: Rows, expected: Rows) -> float:
    common = [name for name in expected if name in found and name != "t"]
    if not common or len(found[common[0]]) != len(expected["t"]):
        return float("inf")
    worst = 0.0
    for name in common:
        size = max(1.0, *map(abs, expected[name]))
        gaps = (abs(a - b) for a, b in zip(found[name], expected[name], strict=True))
        worst = max(worst, *(gap / size for gap in gaps))
    return worst


def _unit(path: Path, _: Path) -> Rows:
    import fmpy
    from fmpy.validation import validate_fmu

    if problems := validate_fmu(str(path)):
        raise RuntimeError(f"{path.name}: {problems}")
    variables = fmpy.read_model_description(str(path)).modelVariables
    (choice,) = (v for v in variables if v.name == "integrator.method")
    number = next(int(i.value) for i in choice.declaredType.items if i.name == METHOD)
    rows = fmpy.simulate_fmu(
        str(path),
        fmi_type="CoSimulation",
        stop_time=STEP * STEPS,
        output_interval=STEP,
        start_values={"integrator.step": STEP, "integrator.method": number},
    )
    return {name: rows[name].tolist() for name in rows.dtype.names}


def _wheel(path: Path, folder: Path) -> Rows:
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder / "in")
    name = path.name.partition("-")[0]
    text = IN_WHEEL.replace("FOLDER", repr(str(folder / "in"))).replace("NAME", name)
    text = text.replace("UNTIL", repr(STEP * STEPS)).replace("STEP", repr(STEP))
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


# By what each is called in the table: how it is made, and what its rows are.
HOSTS: dict[str, tuple[list[str], Callable[[Path, Path], Rows]]] = {
    "FMI 3": (["--as", "fmu"], _unit),
    "FMI 2": (["--as", "fmu", "--fmi", "2"], _unit),
    "wheel": (["--as", "python"], _wheel),
}


def _write(rows: list[list[object]]) -> None:
    head = ["model"]
    for host in HOSTS:
        head += [f"{host}, kB", "made, s", "equal within"]
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(MARK)
    _, _, after = rest.partition("<!-- end -->\n")
    here = machine.describe()
    shown = [
        [x if isinstance(x, str) else f"{x:.0f}" if k % 3 == 1 else f"{x:.1f}" if k % 3 == 2
         else f"{x:.1e}" if x else "0" for k, x in enumerate(row)]
        for row in rows
    ]  # fmt: skip
    text = f"{before}{MARK}\n{here.lines()[0]}\n\n{table(head, shown)}\n<!-- end -->\n{after}"
    PAGE.write_text(text, encoding="utf-8")
