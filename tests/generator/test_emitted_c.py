"""The emitted C, compiled and linked: no warnings anywhere, no names but its own."""

import re

import pytest
from c_harness import (
    BUILDS,
    COMPILERS,
    MODELS,
    ODD,
    RUNTIME,
    STRICT,
    TYPES,
    no_warnings,
    read_model,
    read_text,
    run,
    texts,
    write,
)
from test_render import nasty_program

ALONE = [*RUNTIME, "-Wl,--defsym,pk_scalar_is_double=0"]  # links without the runtime


@pytest.fixture(scope="module", params=texts(), ids=lambda p: p[0])
def model(request):
    return read_text(request.param[1], request.param[0] + ".lag")


@pytest.mark.parametrize(("compiler", "scalar"), BUILDS)
def test_no_warnings(model, compiler, scalar, tmp_path):
    _, program = model
    name = program.equations.model.name
    write(program, tmp_path, self_test=True)
    no_warnings(compiler, scalar, name, tmp_path)
    read = [*STRICT, *TYPES[scalar], "-fsyntax-only"]
    run(compiler, *read, f"{name}_selftest.c", cwd=tmp_path)


def test_no_warnings_in_quad(model, tmp_path):
    _, program = model
    name = program.equations.model.name
    write(program, tmp_path, self_test=True)
    strict = [x for x in STRICT if x != "-Wpedantic"]
    files = [f"{name}.c", f"{name}_selftest.c"]
    run("gcc", *strict, "-DPK_FLOAT128", *files, "-o", "x", "-lquadmath", "-lm", cwd=tmp_path)
    assert re.fullmatch(r"\d+ passed, 0 failed\n", run(tmp_path / "x", cwd=tmp_path))


@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_header_from_cpp(model, compiler, tmp_path):
    _, program = model
    name = program.equations.model.name
    write(program, tmp_path)
    (tmp_path / "use.cpp").write_text(
        f'#include "{name}.h"\n'
        f"int main() {{ {name}_params p; {name}_defaults(&p); return {name}_prepare(&p); }}\n"
    )
    strict = ["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
    run("gcc", "-std=c99", "-c", f"{name}.c", cwd=tmp_path)
    run(compiler, *strict, "use.cpp", f"{name}.o", "-lm", "-o", "use", cwd=tmp_path)
    run(tmp_path / "use", cwd=tmp_path)
    run(compiler, *strict, *RUNTIME, "-c", "use.cpp", cwd=tmp_path)


def test_nasty_text_compiles(tmp_path):
    write(nasty_program(), tmp_path)
    for compiler in COMPILERS:
        for more in ([], RUNTIME, ["-trigraphs"]):
            run(compiler, *STRICT, *more, "-c", "nasty.c", cwd=tmp_path)
        # Names of headers that a user may have included before.
        (tmp_path / "all.c").write_text(
            "#include <complex.h>\n#include <errno.h>\n#include <assert.h>\n#include <stdio.h>\n"
            '#include "nasty.c"\n'
        )
        run(compiler, "-std=gnu99", "-c", "all.c", cwd=tmp_path)


def test_only_prefixed_symbols(model, tmp_path):
    _, program = model
    name = program.equations.model.name
    write(program, tmp_path)
    for more in ([], RUNTIME):
        run("gcc", "-std=c99", "-O2", *more, "-c", f"{name}.c", "-o", "x.o", cwd=tmp_path)
        rows = [line.split() for line in run("nm", "x.o", cwd=tmp_path).splitlines()]
        # .LC0 and the like are the assembler's own, for constants.
        defined = [row[-1] for row in rows if row[-2] != "U" and row[-1][0] != "."]
        missing = {row[-1] for row in rows if row[-2] == "U"}
        assert len(defined) > 20
        assert [symbol for symbol in defined if not symbol.startswith(name + "_")] == []
        library = "sin cos sincos tan exp log pow sqrt atan2 sinh cosh tanh _GLOBAL_OFFSET_TABLE_"
        assert missing <= {*library.split(), *["pk_scalar_is_double"] * bool(more)}


def test_two_models_in_one_program(tmp_path):
    names = ["double_pendulum", "heavy_top"]
    for name in names:
        write(read_model(next(p for p in MODELS if p.stem == name))[1], tmp_path)
    calls = "".join(
        f"    {{\n        struct {n}_params p;\n        pk_real q[{n}_N], v[{n}_N], a[{n}_N];\n"
        f"        {n}_defaults(&p);\n        {n}_start(&p, q, v);\n"
        f"        if ({n}_acceleration(&p, 0, q, v, NULL, a) != 0)\n            return 1;\n"
        f'        printf("%s %.6f\\n", {n}_coordinates[0].name, (double)a[0]);\n    }}\n'
        for n in names
    )
    includes = "".join(f'#include "{n}.h"\n' for n in names)
    main = f"#include <stdio.h>\n{includes}int main(void)\n{{\n{calls}    return 0;\n}}\n"
    (tmp_path / "main.c").write_text(main)
    (tmp_path / "one.c").write_text('#include "double_pendulum.c"\n#include "heavy_top.c"\n' + main)
    sources = [f"{n}.c" for n in names]
    for more in ([], ALONE):
        run("gcc", *STRICT, *more, "main.c", *sources, "-o", "x", "-lm", cwd=tmp_path)
        apart = run(tmp_path / "x", cwd=tmp_path)
        run("clang", *STRICT, *more, "one.c", "-o", "x", "-lm", cwd=tmp_path)
        assert run(tmp_path / "x", cwd=tmp_path) == apart
    assert re.fullmatch(r"theta1 -?\d+\.\d+\nphi -?\d+\.\d+\n", apart)


def test_introspection_without_the_runtime(tmp_path):
    _, program = read_text(ODD)
    write(program, tmp_path)
    (tmp_path / "main.c").write_text(
        "#include <stdio.h>\n"
        '#include "odd.h"\n'
        "int main(void)\n{\n    int i;\n    struct odd_params p;\n    odd_defaults(&p);\n"
        "    for (i = 0; i < odd_PARAMETERS; i++)\n"
        '        printf("%s=%.4g ", odd_parameters[i].what.name,\n'
        "               (double)*(const pk_real *)((const char *)&p + odd_parameters[i].offset));\n"
        '    printf("%s %s\\n", odd_coordinates[odd_q_gamma].name, odd_rates[0].name);\n'
        "    return 0;\n}\n"
    )
    for more in ([], ALONE):
        run("gcc", *STRICT, *more, "main.c", "odd.c", "-o", "x", "-lm", cwd=tmp_path)
        assert run(tmp_path / "x", cwd=tmp_path) == (
            "I=2 M_PI=0.3 k[1]=3 k[2]=4 k[3]=5 linux=0.3333 c=1.2 y1=-0.7 gamma q[1]'\n"
        )
