"""Emitted C is C++ too, headers and sources, with and without the runtime."""

import subprocess
from pathlib import Path

import pytest

from conftest import ROOT
from pkgen.compiler import compile_model
from pkgen.front.read import read

MODELS = sorted((ROOT / "models").rglob("*.lag"))
# Rotations, rolling, families as loops, events.
KEPT = {
    m for m in MODELS if m.stem in ("rattleback", "sine_gordon", "thrown_stone", "rolling_disk")
}
FAMILIES = [f"-DPK_INLINE_{x}" for x in ["ERK", "EMBEDDED", "SPLITTING", "GAUSS", "ENSEMBLE"]]
WAYS = ([], ["-DPK_RUNTIME"], ["-DPK_RUNTIME", *FAMILIES])


def syntax(compiler: str, path: Path, flags: list[str]) -> None:
    words = [compiler, "-x", "c++", "-std=c++17", "-Wall", "-Werror", "-fsyntax-only"]
    words += [f"-I{ROOT}/runtime/include", *flags, str(path)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{path} {flags}\n{done.stderr[:3000]}"


@pytest.mark.parametrize("compiler", ["g++", "clang++"])
@pytest.mark.parametrize("model", MODELS, ids=lambda path: path.stem)
def test_emitted_sources_are_cpp(model: Path, compiler: str, tmp_path: Path) -> None:
    made = compile_model(read(model))
    for name, text in made.files.items():
        (tmp_path / name).write_text(text)
    for flags in WAYS if compiler == "g++" else WAYS[-1:]:
        syntax(compiler, tmp_path / f"{made.model.name}.c", flags)


@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_every_public_header_is_cpp(compiler: str, tmp_path: Path) -> None:
    headers = sorted((ROOT / "runtime/include/pk").glob("*.h"))
    text = "".join(
        f"#include <pk/{h.name}>\n" for h in headers if h.name not in ("inlined.h", "gsl.h")
    )
    (tmp_path / "all.cpp").write_text(text)
    syntax(compiler, tmp_path / "all.cpp", ["-Wextra"])
