"""What the page of `pkgen show` takes from npm: fetched by `npm pack`, and checked.

    python tools/vendor.py            checks the files in the tree against TABLE
    python tools/vendor.py --fetch    fetches them again, of the versions in TABLE

A new version: change its row, fetch, look at what changed, and put the new sums into the row.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

VENDOR = Path(__file__).resolve().parent.parent / "addons" / "web" / "pkgen_web" / "vendor"

# package, version, file in the package, file here, SHA-256
TABLE = [
    (
        "uplot",
        "1.6.32",
        "dist/uPlot.iife.min.js",
        "uPlot.iife.min.js",
        "19c8d4c6ad88929a79f4ae49d6f7161566dfd0ba3d15cc495e974f787eb78f1f",
    ),
    (
        "uplot",
        "1.6.32",
        "dist/uPlot.min.css",
        "uPlot.min.css",
        "df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04",
    ),
    (
        "uplot",
        "1.6.32",
        "LICENSE",
        "uPlot.LICENSE",
        "8f989229699b4fe2f1a0432d0e9edc338a8a911e250e2d1b01ecd770a5f5b1bd",
    ),
]


def wrong() -> list[str]:
    """Files that are not those of the table; empty where all is well."""
    found = []
    for _, _, _, here, digest in TABLE:
        path = VENDOR / here
        if not path.exists() or hashlib.sha256(path.read_bytes()).hexdigest() != digest:
            found.append(here)
    known = {here for _, _, _, here, _ in TABLE}
    return found + [path.name for path in VENDOR.iterdir() if path.name not in known]


def fetch() -> None:
    with tempfile.TemporaryDirectory() as folder:
        for package in sorted({f"{name}@{version}" for name, version, *_ in TABLE}):
            subprocess.run(["npm", "pack", package], cwd=folder, check=True, capture_output=True)
        for name, version, inside, here, _ in TABLE:
            with tarfile.open(Path(folder) / f"{name}-{version}.tgz") as archive:
                member = archive.extractfile(f"package/{inside}")
                assert member is not None, inside
                (VENDOR / here).write_bytes(member.read())


if __name__ == "__main__":
    if "--fetch" in sys.argv:
        fetch()
    if bad := wrong():
        sys.exit("not as in the table: " + ", ".join(bad))
    print(f"{len(TABLE)} files as in the table")
