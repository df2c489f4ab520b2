"""Runs tests in a copy of the tree from which add-ons are deleted.

    python tools/without_addons.py -- -q tests          without any, as `make test` runs these
python tools/without_addons.py film -- -q addons    without one
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def copied(to: Path, gone: list[str]) -> None:
    """What git knows and what is new, but for what is ignored."""
    listed = ["git", "ls-files", "-co", "--exclude-standard"]
    files = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    shutil.rmtree(to, ignore_errors=True)
    for name in files.splitlines():
        parts = Path(name).parts
        if (ROOT / name).exists() and not (parts[0] == "addons" and parts[1] in gone):
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, to / name, follow_symlinks=False)


def python_of(tree: Path) -> Path:
    """An interpreter with the packages of this one, but for pkgen, which is that of the tree."""
    venv.create(tree / ".venv", with_pip=False)
    own = Path(sysconfig.get_path("purelib", vars={"base": str(tree / ".venv")}))
    packages = [path for path in sys.path if path.endswith("-packages")]
    lines = [tree / "generator", *packages]  # their .pth files are not read
    (own / "tree.pth").write_text("".join(f"{line}\n" for line in lines))
    return tree / ".venv" / "bin" / "python"


def main() -> int:
    end = sys.argv.index("--")
    gone = sys.argv[1:end] or [path.name for path in (ROOT / "addons").iterdir()]
    tree = ROOT / "build" / "without" / "-".join(sorted(gone))[:60]
    copied(tree, gone)
    subprocess.run(["git", "init", "-q"], cwd=tree, check=True)  # tests ask git for the files
    subprocess.run(["git", "add", "-A"], cwd=tree, check=True)
    command = [python_of(tree), "-m", "pytest", *sys.argv[end + 1 :]]
    return subprocess.run(command, cwd=tree, env=os.environ | {"PYTHONPATH": ""}).returncode


if __name__ == "__main__":
    sys.exit(main())
