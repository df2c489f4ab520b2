"""Runs pytest in a copy of the tree without add-ons.

python tools/without_addons.py -- -q tests          without all of them
python tools/without_addons.py film -- -q addons    without one
python tools/without_addons.py --each -- -q         without each in turn: the tests that name it,
                                                    and those that look at all add-ons
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OF_ALL = [
    "tests/test_architecture.py",
    "tests/test_addons_read.py",
    "tests/test_package.py",
    "tests/cli/test_command_line.py",
]


def copied(to: Path, gone: list[str]) -> None:
    """Copies the files of git and new ones, without ignored files and the add-ons `gone`."""
    listed = ["git", "ls-files", "-co", "--exclude-standard"]
    files = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    shutil.rmtree(to, ignore_errors=True)
    for name in files.splitlines():
        parts = Path(name).parts
        if os.path.lexists(ROOT / name) and not (parts[0] == "addons" and parts[1] in gone):
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, to / name, follow_symlinks=False)


def python_of(tree: Path) -> Path:
    """Returns an interpreter with the packages of this one, but with pkgen from the tree."""
    venv.create(tree / ".venv", with_pip=False)
    own = Path(sysconfig.get_path("purelib", vars={"base": str(tree / ".venv")}))
    packages = [p for p in sys.path if Path(p).name in ("site-packages", "dist-packages")]
    (own / "tree.pth").write_text("".join(f"{line}\n" for line in (tree / "generator", *packages)))
    return tree / ".venv" / "bin" / "python"


def tested(gone: list[str], words: list[str]) -> int:
    print(f"without {', '.join(gone)}:", flush=True)
    tree = ROOT / "build" / "without" / (gone[0] if len(gone) == 1 else "all")
    copied(tree, gone)
    subprocess.run(["git", "init", "-q"], cwd=tree, check=True)  # tests ask git for the files
    subprocess.run(["git", "add", "-A"], cwd=tree, check=True)
    command = [python_of(tree), "-m", "pytest", *words]
    return subprocess.run(command, cwd=tree, env=os.environ | {"PYTHONPATH": ""}).returncode


def noticing(gone: str) -> list[str]:
    """Returns test files: those of other add-ons that name it, its commands, hosts or options."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    names = re.findall(rf'^"?(?:\w+\.)?(\w+)"? = "pkgen_{gone}\b', text, re.M)
    word = re.compile(rf"""["']({"|".join(names)})["']|--({"|".join(names)})\b|pkgen_{gone}\b""")
    tests = (path for path in (ROOT / "addons").glob("*/tests/**/test_*.py"))
    others = (path for path in tests if path.parts[len(ROOT.parts) + 1] != gone)
    found = [path for path in others if word.search(path.read_text(encoding="utf-8"))]
    return [*OF_ALL, *(str(path.relative_to(ROOT)) for path in sorted(found))]


def main() -> int:
    end = sys.argv.index("--")
    names, words = sys.argv[1:end], sys.argv[end + 1 :]
    there = sorted(path.name for path in (ROOT / "addons").iterdir() if path.is_dir())
    if names == ["--each"]:
        return max(tested([name], [*words, *noticing(name)]) for name in there)
    return tested(names or there, words)


if __name__ == "__main__":
    sys.exit(main())
