"""C of families as loops: clean in every type with gcc and clang, sound under sanitizers, the same
code for every size."""

import random
import re

import pytest
from c_harness import BUILDS, STRICT, no_warnings, run
from loop_models import FPUT, MODELS
from loop_runs import bodies
from rotation_models import made
from test_loops_bound import model as bound
from total_models import RATES, TOTALS

from pkgen.compiler import compile_model
from pkgen.source import Source

MORE = {
    "tied": bound(random.Random(5)),
    "spins": made(random.Random(3), 3).text,
    "bodies": bodies(random.Random(1)) + "observe up[i = 1..N] = (R[i]*[0, 0, 1]).z\n",
}
TEXTS = MORE | {name: text for name, (text, _) in (MODELS | TOTALS | RATES).items()}
FELT = ("mean", "started", "seen", "pushed", "hung")  # sums, and what is computed before rows


def emitted(text: str, directory, sizes=None) -> str:
    compilation = compile_model(Source("model.lag", text), sizes=sizes)
    assert not compilation.equations.dense
    for name, content in compilation.files.items():
        (directory / name).write_text(content, encoding="utf-8")
    return compilation.model.name


@pytest.mark.parametrize(("compiler", "scalar"), BUILDS)
@pytest.mark.parametrize(
    "name",
    ["ring", "paired", "cart", "wheel", "spin", "lattice", "links", "rated", *FELT, *MORE],
)
def test_clean_in_every_type(name, compiler, scalar, tmp_path):
    model = emitted(TEXTS[name], tmp_path)
    no_warnings(compiler, scalar, model, tmp_path)
    if (compiler, scalar) == ("gcc", "double"):
        strict = [flag for flag in STRICT if flag != "-Wpedantic"]
        run("gcc", *strict, "-DPK_FLOAT128", "-fsyntax-only", f"{model}.c", cwd=tmp_path)


USE = """\
#include <stdio.h>
#include <stdlib.h>
#include "NAME.h"

int main(void)
{
    static const ptrdiff_t sizes[] = {1, 2, 3, 7, 64, 200};
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        struct NAME_params p;
        NAME_sizes(&p);
        p.N = sizes[k];
        void *block = malloc(NAME_block_size(&p));
        NAME_attach(&p, block);
        NAME_defaults(&p);
        if (NAME_prepare(&p) != 0)
            return 1;
        const size_t n = NAME_count(&p);
        double *q = malloc(n * sizeof *q), *v = malloc(n * sizeof *v), *a = malloc(n * sizeof *a);
        double *M = malloc(NAME_mass_size(&p) * sizeof *M), u[3] = {0.3};
        NAME_start(&p, q, v);
        if (NAME_acceleration(&p, 0, q, v, u, a) != 0)
            return 2;
        NAME_mass(&p, 0, q, v, u, M);
        NAME_canonical(&p, 0, q, v, u, a, M);
        printf("%g\\n", NAME_energy(&p, 0, q, v, u));
        ADVANCE
        free(q), free(v), free(a), free(M), free(block);
    }
    return 0;
}
"""

MASS = "NAME_mass"
HAVE_ONE_MORE = ("seen", "pushed", "hung")  # member at least
OBSERVE = """
            double *g = malloc((n + 9) * sizeof *g);
            NAME_observe(&p, 0, q, v, u, g);
            free(g);
        """
SINGULARITY = """{
            double *g = malloc(NAME_singularity_count(&p) * sizeof *g);
            NAME_singularity(&p, 0, q, v, u, g);
            free(g);
        }"""


@pytest.mark.parametrize(
    "name",
    ["fput", "ring", "paired", "beam", "wheel", "cart", "links", "rated", *FELT],
)
def test_sound_under_sanitizers(name, tmp_path):
    model = emitted(TEXTS[name], tmp_path)
    text = USE if name not in HAVE_ONE_MORE else USE.replace("{1, 2,", "{2, 2,")
    if name in ("links", "seen", "hung"):  # which has no kernel of M
        text = text.replace("NAME_mass_size(&p)", "n").replace(MASS, "NAME_gradient")
    text = text.replace("NAME", model)
    more = {
        "fput": "fput_verlet(&p, 0, 0.01, 20, q, v);",
        "wheel": SINGULARITY,
        "cart": SINGULARITY,
        "links": SINGULARITY,
    }
    more |= dict.fromkeys(("mean", "hung"), SINGULARITY)
    more |= dict.fromkeys(FELT, f"{{{OBSERVE}}}{more.get(name, '')}")
    text = text.replace("ADVANCE", more.get(name, "").replace("NAME", model))
    (tmp_path / "use.c").write_text(text)
    flags = ["-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    run("gcc", *STRICT, *flags, f"{model}.c", "use.c", "-o", "use", "-lm", cwd=tmp_path)
    assert len(run(tmp_path / "use", cwd=tmp_path).split()) == 6


def test_code_does_not_grow_with_the_size(tmp_path):
    texts = []
    for size in (3, 1_000_000):
        emitted(FPUT, tmp_path, {"N": size})
        text = (tmp_path / "fput.c").read_text() + (tmp_path / "fput.h").read_text()
        texts.append(re.sub(rf"\b{size}\b", "SIZE", text))
    assert texts[0].replace("= SIZE;", "") != ""
    assert len(texts[0].splitlines()) == len(texts[1].splitlines())
    assert "q[1000" not in texts[1]


def test_lines_fit(tmp_path):
    for name in ("ring", "paired", "cart", "links", "rated", "mean", *MORE):
        model = emitted(TEXTS[name], tmp_path)
        for suffix in "ch":
            for line in (tmp_path / f"{model}.{suffix}").read_text().splitlines():
                assert len(line) <= 100, line
