"""`python -m bench exports [--docs] [--only NAME,...] [--hosts NAME,...] [--again]`: every model to
every host that runs it here, built as its users do.

Of each: kB, seconds of the processor for the export, and the largest difference from `pkgen run`
with the same method and step, in units of each column's size (at least 1): export_hosts.py. What
is measured is kept in build/bench/exports.json, so that a run that was ended goes on from there, or
from the tables in docs, which are kept with --docs; --again measures it anew. Exit code 4 if one
differs by more than its host may, or fails.
"""

from __future__ import annotations

import argparse
import json
import re
import resource
import statistics
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from . import machine
from .builds import OUTPUT
from .export_hosts import HOSTS, METHOD, ROOT, STEP, STEPS, Case, Host, Rows
from .tables import table

PAGE = ROOT / "addons/hosts/README.md"
MARK, END = "<!-- python -m bench exports --docs -->\n", "<!-- end -->\n"
FIRST = "kB, s, within"  # the first cell of the table of models
# What a host may refuse a model for, and the word for it in the table.
REFUSALS = {
    r"has constraints": "constraints",
    r"has rotations": "rotations",
    r"families are too long": "too long",
}
Found = dict[str, dict[str, dict]]  # model, host


# Steps of rk4 that end at other places beside the knots of tables differ by the error of rk4.
OVER_KNOTS = 1e-3


def hosted() -> list[Path]:
    """Returns the models of the collection that live pages and other hosts run: these refuse
    sample blocks, contacts and noise."""
    refused = re.compile(r"^(sample|noise|contact|impact|friction|mode) ", re.MULTILINE)
    every = sorted((ROOT / "models").rglob("*.lag"), key=lambda path: path.stem)
    return [path for path in every if not refused.search(path.read_text(encoding="utf-8"))]


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench exports", description=__doc__)
    parser.add_argument("--docs", action="store_true", help="write the tables into its page")
    parser.add_argument("--only", metavar="LIST", help="these models alone")
    parser.add_argument("--hosts", metavar="LIST", help="these hosts alone")
    parser.add_argument("--again", action="store_true", help="what is kept is measured anew")
    options = parser.parse_args(words)
    kept = OUTPUT / "exports.json"
    found: Found = json.loads(kept.read_text()) if kept.exists() else {}
    paths = hosted()
    for model, row in _read().items():
        if any(path.stem == model for path in paths):
            found[model] = row | found.get(model, {})
    hosts = {k: h for k, h in HOSTS.items() if k in (options.hosts or ",".join(HOSTS)).split(",")}
    for model in paths:
        if options.only and model.stem not in options.only.split(","):
            continue
        of = found.setdefault(model.stem, {})
        for name, host in hosts.items():
            if (
                name in of and not options.again and "failed" not in of[name]
            ) or not host.is_here():
                continue
            of[name] = _measured(model, host)
            print(model.stem, name, *of[name].values(), flush=True)
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_text(json.dumps(found, indent=1))
    wrong = list(_wrong(found))
    for line in wrong:
        print(line, file=sys.stderr)
    if options.docs:
        _write(found)
    return 4 if wrong else 0


def _wrong(found: Found):
    for model, of in found.items():
        for name, row in of.items():
            if "failed" in row:
                yield f"{model}, {name}: {row['failed']}"
            elif "off" in row and not row["off"] <= (
                OVER_KNOTS if row.get("tables") else HOSTS[name].within
            ):
                yield f"{model}, {name}: {row['off']:.3g}"


def _measured(model: Path, host: Host) -> dict[str, object]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        made = folder / ("made.c" if host.words[0] == "single" else "made")
        done = _pkgen("export", str(model), "--as", *host.words, "-o", str(made))
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode:
            for words, word in REFUSALS.items():
                if done.returncode == 2 and re.search(words, done.stderr):
                    return {"refused": word}
            return {"failed": done.stderr.strip()[:300]}
        size = sum(path.stat().st_size for path in [made, *made.rglob("*")] if path.is_file())
        seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        if made.is_dir() and host.words[0] in ("fmu", "python"):
            (made,) = made.iterdir()
        of = _described(model)
        try:
            off = host.off(Case(model, of, made, folder, lambda *more: _run(model, *more)))
        except Exception as error:
            return {"failed": f"{type(error).__name__}: {error}"[:2000]}
        found = {"kB": round(size / 1000), "s": round(seconds, 1), "off": off}
        return found | ({"tables": True} if of["tables"] else {})


def _pkgen(*words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "pkgen", *words]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)


@cache
def _described(model: Path) -> dict:
    return json.loads(_pkgen("describe", str(model), "--json").stdout)


@cache
def _run(model: Path, *more: str) -> Rows:
    words = ("--method", METHOD, "--step", str(STEP), "--until", str(STEP * STEPS))
    done = _pkgen("run", str(model), *words, "--every", str(STEP), *more)
    if done.returncode:
        raise RuntimeError(f"pkgen run: {done.stderr}")
    head, *lines = done.stdout.splitlines()
    columns = zip(*(map(float, line.split(",")) for line in lines), strict=True)
    return {name: list(column) for name, column in zip(head.split(","), columns, strict=True)}


def _page() -> tuple[str, str, str]:
    """What is before the tables, they, and what is behind."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(MARK)
    tables, _, after = rest.partition(END)
    return before, tables, after


def _read() -> Found:
    """What the tables in docs have, as they round it."""
    lines = [line.strip("| ").split("|") for line in _page()[1].splitlines() if line[:1] == "|"]
    rows = [[cell.strip() for cell in line] for line in lines]
    heads = [k for k, row in enumerate(rows) if row[0] == FIRST]
    if not heads:
        return {}
    hosts, models = rows[heads[0]][1:], rows[heads[0] + 2 :]
    return {
        model: {host: _of(cell) for host, cell in zip(hosts, cells, strict=True) if cell != "-"}
        for model, *cells in models
    }


def _of(cell: str) -> dict:
    kB, *more = cell.split(", ")
    return {"kB": int(kB), "s": float(more[0]), "off": float(more[1])} if more else {"refused": kB}


def _write(found: Found) -> None:
    before, tables, after = _page()
    here = machine.describe().lines()[0]
    machines = [line for line in tables.splitlines() if line and line[0] != "|"]
    if here not in machines and found != _read():
        machines.append(here)
    rows = [[m, *(_cell(of.get(name)) for name in HOSTS)] for m, of in sorted(found.items())]
    parts = ("", *machines, _by_host(found), table([FIRST, *HOSTS], rows))
    text = "\n\n".join(parts)[1:]
    PAGE.write_text(f"{before}{MARK}{text}\n{END}{after}", encoding="utf-8")


def _by_host(found: Found) -> str:
    rows, models = [], len(hosted())
    for name, host in HOSTS.items():
        all_ = [of[name] for of in found.values() if name in of]
        good = [row for row in all_ if "off" in row]
        if not good:
            continue
        low, high = min(row["kB"] for row in good), max(row["kB"] for row in good)
        refused = sum("refused" in row for row in all_)
        seconds = statistics.median(row["s"] for row in good)
        worst = max(row["off"] for row in good)
        count = f"{len(good)} of {models}"
        rows.append((name, count, refused, host.by, _off(worst), f"{low}–{high}", f"{seconds:.1f}"))
    head = ("", "models", "refused", "validated by", "equal within", "kB", "s, median")
    return table(head, rows)


def _cell(row: dict | None) -> str:
    if row is None or "failed" in row:
        return "-"
    return row.get("refused") or f"{row['kB']}, {row['s']:.1f}, {_off(row['off'])}"


def _off(x: float) -> str:
    return f"{x:.0e}".replace("e-0", "e-") if x else "0"
