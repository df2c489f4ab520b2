"""The wheel of pkgen, and beside it what it holds and needs (an SBOM, CycloneDX).

    python tools/release [DIR]      default: build/dist

The same files give the same bytes, wherever and whenever they are built: a copy of what git tracks
is built, with rights and dates of one kind. The date is SOURCE_DATE_EPOCH, else that of the last
commit, else 1980. setuptools is the one that pyproject.toml names for `dist`, since others write
other metadata.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TAKEN = ("generator", "addons", "runtime", "pyproject.toml", "README.md", "LICENSE")
FIRST_DATE = 315532800  # the earliest that a zip file can hold
BUILD = "import sys; from setuptools.build_meta import build_wheel; build_wheel(sys.argv[1])"


def tracked() -> list[str]:
    """The files of a wheel's source: what git tracks; in a tree without git all there are."""
    command = ["git", "ls-files", "-z", *TAKEN]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    if done.returncode == 0 and done.stdout:
        return [name for name in done.stdout.rstrip("\0").split("\0") if (ROOT / name).exists()]
    files = (path for name in TAKEN for path in [ROOT / name, *(ROOT / name).rglob("*")])
    names = (
        path.relative_to(ROOT).as_posix() for path in files if path.is_file() or path.is_symlink()
    )
    return sorted(name for name in names if not re.search(r"__pycache__/|\.egg-info/", name))


def date() -> int:
    if given := os.environ.get("SOURCE_DATE_EPOCH"):
        return max(int(given), FIRST_DATE)
    command = ["git", "log", "-1", "--format=%ct"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    return int(done.stdout) if done.returncode == 0 else FIRST_DATE


def copy(folder: Path) -> None:
    for name in tracked():
        place = folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, place, follow_symlinks=False)
        if not place.is_symlink():
            place.chmod(0o644)


def tagged() -> str:
    """The version of the last commit's tag, v1.2.3; "" where it has none."""
    command = ["git", "describe", "--tags", "--exact-match", "--match", "v[0-9]*"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    return done.stdout.strip().removeprefix("v") if done.returncode == 0 else ""


def wanted() -> str:
    """The setuptools of pyproject.toml's `dist`."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    return re.search(r'"setuptools==([\d.]+)"', text)[1]


def build(directory: Path, epoch: int) -> Path:
    """The wheel, in a directory."""
    directory.mkdir(parents=True, exist_ok=True)
    os.umask(0o022)
    with tempfile.TemporaryDirectory() as scratch:
        tree, made = Path(scratch, "tree"), Path(scratch, "made")
        made.mkdir()
        copy(tree)
        if tag := tagged():
            place = tree / "generator/pkgen/version.py"
            text = re.sub(r"(?m)^(__version__ = ).*", rf'\1"{tag}"', place.read_text())
            place.write_text(text)
        env = {**os.environ, "SOURCE_DATE_EPOCH": str(epoch)}
        command = [sys.executable, "-c", BUILD, str(made)]
        done = subprocess.run(command, cwd=tree, env=env, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"release: the wheel could not be built\n{done.stderr[-2000:]}")
        (wheel,) = made.iterdir()
        return Path(shutil.copy(wheel, directory / wheel.name))


def main(words: list[str]) -> int:
    if version("setuptools") != wanted():
        found = version("setuptools")
        sys.exit(f"release: setuptools is {found}, not {wanted()}: pip install -e '.[dist]'")
    try:
        from sbom import written
    except ImportError as error:
        sys.exit(f"release: there is no {error.name}: pip install -e '.[dist]'")
    epoch = date()
    wheel = build(Path(words[0]) if words else ROOT / "build" / "dist", epoch)
    for path in (wheel, written(wheel, epoch)):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
