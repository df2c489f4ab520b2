"""A model in projects of CMake, make with pkg-config, Meson: the examples of the docs."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from conftest import ROOT
from pkgen.run import build
from pkgen.system import toolchain

PAGE = (ROOT / "addons/hosts/export-cmake.md").read_text()
MODEL = ROOT / "models/double_pendulum.lag"
(SAID,) = re.findall(r"^```text\n(.*?)^```", PAGE, re.M | re.S)


def block(language: str) -> str:
    (text,) = re.findall(rf"^```{language}\n(.*?)^```", PAGE, re.M | re.S)
    return text


def needs(*tools: str) -> pytest.MarkDecorator:
    missing = [tool for tool in tools if not shutil.which(tool)]
    return pytest.mark.skipif(bool(missing), reason=f"no {', '.join(missing)} here")


def said(*words: object, cwd: Path, env: dict[str, str] | None = None) -> str:
    """Of a command that is no child of the `make` that runs the tests."""
    env = {k: v for k, v in (env or os.environ).items() if k not in ("MAKEFLAGS", "MFLAGS")}
    done = subprocess.run(
        list(map(str, words)), cwd=cwd, capture_output=True, text=True, env=env, check=False
    )
    assert done.returncode == 0, f"{words}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
    return done.stdout


@pytest.fixture(scope="module")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `make install` makes, but for the environment of Python."""
    folder = tmp_path_factory.mktemp("installed")
    built = build.runtime_library(toolchain.find_toolchain())
    said("make", "-s", "install-runtime", f"PREFIX={folder}", f"BUILT={built}", cwd=ROOT)
    (folder / "bin").mkdir()
    (folder / "bin/pkgen").write_text(f'#!/bin/sh\nexec {sys.executable} -m pkgen "$@"\n')
    (folder / "bin/pkgen").chmod(0o755)
    return folder.rename(folder.with_name("moved"))


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "CMakeLists.txt").write_text(block("cmake"))
    (tmp_path / "main.c").write_text(block("c"))
    shutil.copy(MODEL, tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    "generator",
    [
        pytest.param("Ninja", marks=needs("cmake", "ninja")),
        pytest.param("Unix Makefiles", marks=[needs("cmake", "make"), pytest.mark.long]),
    ],
)
def test_cmake_builds_and_follows_the_model(generator: str, prefix: Path, project: Path) -> None:
    made = project / "build"
    words = ("-S", ".", "-B", made, "-G", generator, f"-DCMAKE_PREFIX_PATH={prefix}")
    said("cmake", *words, cwd=project)
    said("cmake", "--build", made, cwd=project)
    assert said(made / "swing", cwd=project) == SAID
    source = made / "swing.models/double_pendulum.c"
    first = source.stat().st_mtime_ns
    said("cmake", "--build", made, cwd=project)
    assert source.stat().st_mtime_ns == first
    time.sleep(1.1)  # make sees whole seconds on some file systems
    model = project / MODEL.name
    model.write_text(model.read_text().replace("9.81", "1.62"))
    said("cmake", "--build", made, cwd=project)
    assert source.stat().st_mtime_ns > first
    assert said(made / "swing", cwd=project) != SAID


@needs("cmake", "ninja")
def test_a_project_of_cpp_alone(prefix: Path, project: Path) -> None:
    lists = block("cmake").replace("swing C)", "swing CXX)").replace("main.c", "main.cpp")
    (project / "CMakeLists.txt").write_text(lists)
    (project / "main.c").rename(project / "main.cpp")
    words = ("-S", ".", "-B", "build", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}")
    said("cmake", *words, cwd=project)
    said("cmake", "--build", "build", cwd=project)
    assert said(project / "build/swing", cwd=project) == SAID


@needs("cmake", "ninja")
@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("pk_add_model(swing)", "name a model"),
        ("pk_add_model(swing nosuch.lag)", "there is no"),
        ("pk_add_model(swing main.c)", "no statement `model NAME`"),
    ],
)
def test_what_is_wrong_in_cmake_is_said(
    call: str, message: str, prefix: Path, project: Path
) -> None:
    lists = re.sub(r"pk_add_model\(.*\)", call, block("cmake"))
    (project / "CMakeLists.txt").write_text(lists)
    words = ("cmake", "-S", ".", "-B", "build", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}")
    done = subprocess.run(words, cwd=project, capture_output=True, text=True, check=False)
    assert done.returncode != 0 and message in " ".join(done.stderr.split())


@needs("make", "pkg-config")
def test_make_with_pkg_config(prefix: Path, project: Path) -> None:
    rules = """all: swing
gen/double_pendulum.c: ; pkgen double_pendulum.lag --runtime -o gen --depfile gen/double_pendulum.d
-include gen/double_pendulum.d
swing: main.c gen/double_pendulum.c
	cc main.c gen/double_pendulum.c -Igen `pkg-config --cflags --libs pk` -o $@
"""
    (project / "Makefile").write_text(rules)
    paths = {
        "PKG_CONFIG_PATH": f"{prefix}/lib/pkgconfig",
        "PATH": f"{prefix}/bin:{os.environ['PATH']}",
    }
    env = {**os.environ, **paths}
    assert "pkgen" in said("make", cwd=project, env=env)
    assert said(project / "swing", cwd=project) == SAID
    assert "pkgen" not in said("make", cwd=project, env=env)
    os.utime(project / MODEL.name)
    assert "pkgen" in said("make", cwd=project, env=env)


@pytest.mark.long
@needs("meson", "ninja")
def test_meson_takes_it_as_a_subproject(prefix: Path, project: Path) -> None:
    (project / "meson.build").write_text(block("meson"))
    source = project / "subprojects/pkgen"
    source.mkdir(parents=True)
    shutil.copy(ROOT / "meson.build", source)
    shutil.copytree(ROOT / "runtime", source / "runtime")
    env = {**os.environ, "PATH": f"{prefix}/bin:{os.environ['PATH']}"}
    said("meson", "setup", "build", cwd=project, env=env)
    said("ninja", "-C", "build", cwd=project, env=env)
    assert said(project / "build/swing", cwd=project) == SAID
    model = project / MODEL.name
    model.write_text(model.read_text().replace("9.81", "1.62"))
    said("ninja", "-C", "build", cwd=project, env=env)
    assert said(project / "build/swing", cwd=project) != SAID
