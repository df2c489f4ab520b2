"""A model and a library of different scalar types do not link: they would crash."""

import subprocess
from pathlib import Path

import pytest

from conftest import ROOT, run_pkgen
from pkgen.run.build import runtime_library
from pkgen.system.toolchain import find_toolchain

MAIN = """#include <stdio.h>
#include <pk/pk.h>
#include "heavy_top.h"
int main(void)
{
    struct heavy_top_params p;
    heavy_top_defaults(&p);
    heavy_top_prepare(&p);
    const struct pk_problem problem = {.system = &heavy_top_system, .params = &p};
    printf("%zu\\n", pk_integrator_size(&problem, pk_method_find("gauss4")));
    return 0;
}
"""


@pytest.mark.parametrize("scalar", ["", "-DPK_FLOAT", "-DPK_LONG_DOUBLE"])
def test_a_library_of_another_scalar_does_not_link(scalar: str, tmp_path: Path) -> None:
    assert run_pkgen(ROOT / "models/heavy_top.lag", "--runtime", "-o", tmp_path).returncode == 0
    (tmp_path / "main.c").write_text(MAIN)
    tools = find_toolchain()
    library = runtime_library(tools) / "libpk.a"
    flags = ["-std=c11", "-O1", "-DPK_RUNTIME", f"-I{ROOT}/runtime/include", *scalar.split()]
    command = [*tools.cc, *flags, "main.c", "heavy_top.c", str(library), "-lm", "-o", "main"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    if not scalar:
        assert done.returncode == 0, done.stderr
        assert int(subprocess.run([tmp_path / "main"], capture_output=True, text=True).stdout) > 0
        return
    name = scalar.removeprefix("-DPK_").lower()
    assert done.returncode != 0 and f"pk_scalar_is_{name}" in done.stderr
