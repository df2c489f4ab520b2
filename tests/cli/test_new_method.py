"""A method is coefficients and a row, a diagnostic a file and a row: added so to a copy of
the runtime, both are there for every command."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT

# A. Ralston, Math. Comp. 16 (1962) 431: order 3 of least error.
TABLE = """
static const pk_real pk_ralston3_c[] = {PK_C(0.0), PK_C(0.5), PK_C(0.75)};
static const pk_real pk_ralston3_a[] = {PK_C(0.5), PK_C(0.0), PK_C(0.75)};
static const pk_real pk_ralston3_b[] = {PK_C(2.0) / PK_C(9.0), PK_C(1.0) / PK_C(3.0),
                                        PK_C(4.0) / PK_C(9.0)};
static const struct pk_tableau pk_ralston3_table = {
    .stages = 3, .c = pk_ralston3_c, .a = pk_ralston3_a, .b = pk_ralston3_b};

#endif
"""
METHOD = '    X(A, ralston3, 3, 3, 0, 0, ralston3, "A. Ralston (1962)") \\\n'
DIAGNOSTIC = "    X(extent, OF_ROWS, NONE) \\\n"
FILE = """#include "parts.h"

void diagnose_extent(struct diagnostics *d)
{
    pk_real most = 0;
    for (size_t k = 0; k < d->n_rows; k++) {
        const pk_real q = d->rows[k * (1 + 2 * d->run->settings.n) + 1];
        most = q > most ? q : -q > most ? -q : most;
    }
    if (diagnose_told(d, PK_DONE, "done", NULL))
        json_real(&d->json, "most", most);
}
"""
MODEL = "model swing\ncoord x\nkinetic x'^2/2\npotential 1 - cos(x)\nstart x = 1\n"


def insert(path: Path, before: str, text: str) -> None:
    old = path.read_text()
    assert old.count(before) == 1
    path.write_text(old.replace(before, text + before))


@pytest.fixture(scope="module")
def extended(tmp_path_factory: pytest.TempPathFactory):
    folder = tmp_path_factory.mktemp("extended")
    runtime = folder / "pkgen_runtime"
    shutil.copytree(ROOT / "runtime", runtime)
    tables = runtime / "include/pk/step/tables.h"
    tables.write_text(tables.read_text().rpartition("#endif")[0] + TABLE)
    insert(runtime / "include/pk/methods.h", "    X(A, rk4, 4, 4, 0,", METHOD)
    insert(runtime / "run/diagnose/diagnostics.h", "    X(lrl, MOTION, PARTICLES)", DIAGNOSTIC)
    (runtime / "run/diagnose/extent.c").write_text(FILE)
    (folder / "swing.lag").write_text(MODEL)
    env = {**os.environ, "PYTHONPATH": str(folder), "PKGEN_CACHE": str(folder / "cache")}
    env["CFLAGS"] = "-O0"

    def run(*words: object) -> dict:
        command = [sys.executable, "-m", "pkgen", *map(str, words), "--json"]
        done = subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


def test_a_method_is_there_and_has_its_order(extended) -> None:
    listed = {m["name"]: m for m in extended("methods")}
    assert (listed["ralston3"]["order"], listed["ralston3"]["stages"]) == (3, 3)
    # That of every method of order and stages 3: |1 + z + z^2/2 + z^3/6| = 1 at y = sqrt(3).
    assert abs(listed["ralston3"]["limits"]["imaginary"] - 3**0.5) < 1e-9
    found = {}
    for method, setting in (("ralston3", 0.02), ("ralston3", 0.01), ("gauss", None)):
        words = ("--step", setting) if setting else ("--rtol", "1e-13")
        done = extended("run", "swing.lag", "--until", 4, "--method", method, *words, "-o", "x.csv")
        found[method, setting] = done["report"]["q"][0]
    exact = found["gauss", None]
    coarse, fine = (abs(found["ralston3", h] - exact) for h in (0.02, 0.01))
    assert fine > 1e-9 and 7.5 < coarse / fine < 8.5


def test_a_diagnostic_is_there(extended) -> None:
    words = ("--until", 4, "--diagnose", "extent", "-o", "x.csv")
    done = extended("run", "swing.lag", *words)
    assert abs(done["report"]["diagnostics"]["extent"]["most"] - 1) < 1e-3
