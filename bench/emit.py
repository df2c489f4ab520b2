"""`python bench/emit.py MODEL FOLDER [OPTIONS]`: the C that `pkgen run MODEL OPTIONS` compiles.

Without options it has every kernel, since programs of several methods are built from it."""

from __future__ import annotations

import sys
from pathlib import Path

from pkgen.__main__ import parser_of
from pkgen.back.kernels import all_but
from pkgen.compiler import compile_model
from pkgen.front.read import read
from pkgen.scenes import compile_plan as scene_use
from pkgen.scenes.lengths import UNROLL


def main(model: str, folder: str, *words: str) -> None:
    options = parser_of("run").parse_args([model, *words])
    use = scene_use.of_run(options) if words else None
    kernels = None if words else all_but() | {"jet"}
    made = compile_model(read(model), libm=options.libm, unroll=UNROLL, use=use, kernels=kernels)
    for name, text in made.files.items():
        Path(folder, name).write_text(text)


if __name__ == "__main__":
    main(*sys.argv[1:])
