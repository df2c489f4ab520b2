"""The wheel of pkgen: the same bytes wherever and whenever it is built, and its bill."""

import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from email import message_from_bytes
from pathlib import Path

import pytest

from conftest import ROOT

pytestmark = [pytest.mark.long, pytest.mark.needs_addon]
cyclonedx = pytest.importorskip("cyclonedx", reason="pip install -e '.[dist]'")
TOOL = "tools/release"


def copied(folder: Path) -> Path:
    """The repository's files elsewhere, with what an editor and a build leave, and without git."""
    names = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True).stdout
    for name in names.splitlines():
        if name.startswith(("generator/", "addons/", "runtime/", TOOL)) or "/" not in name:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, folder / name, follow_symlinks=False)
            if not (folder / name).is_symlink():
                os.chmod(folder / name, 0o600)
    stale = folder / "generator/pkgen/__pycache__/stale.cpython-311.pyc"
    stale.parent.mkdir()
    stale.write_bytes(b"")
    return folder


def released(tree: Path, out: Path, mask: int, **variables: str) -> tuple[Path, Path]:
    command = [sys.executable, tree / TOOL, out]
    env = {**os.environ, **variables}
    done = subprocess.run(command, capture_output=True, text=True, env=env, umask=mask)
    assert done.returncode == 0, done.stderr
    wheel, bill = (Path(line) for line in done.stdout.splitlines())
    return wheel, bill


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return released(ROOT, tmp_path_factory.mktemp("one"), 0o022, SOURCE_DATE_EPOCH="1700000000")


def test_two_builds_give_the_same_bytes(made: tuple[Path, Path], tmp_path: Path) -> None:
    tree = copied(tmp_path / "elsewhere")
    how = {"TZ": "Asia/Tokyo", "LC_ALL": "C", "PYTHONHASHSEED": "7"}
    again = released(tree, tmp_path / "two", 0o077, SOURCE_DATE_EPOCH="1700000000", **how)
    for one, other in zip(made, again, strict=True):
        assert one.name == other.name and one.read_bytes() == other.read_bytes()
    later = released(tree, tmp_path / "three", 0o022, SOURCE_DATE_EPOCH="1700000100")
    assert later[0].read_bytes() != made[0].read_bytes()


def test_the_wheel_has_what_git_has(made: tuple[Path, Path]) -> None:
    listed = ["git", "ls-files", "generator/pkgen", "runtime", "addons/*/pkgen_*"]
    names = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True).stdout.splitlines()
    moved = (re.sub(r"^(generator|addons/\w+)/", "", n) for n in names)
    places = {re.sub(r"^runtime/", "pkgen_runtime/", n) for n in moved}
    with zipfile.ZipFile(made[0]) as archive:
        held = {name for name in archive.namelist() if ".dist-info/" not in name}
    assert {p for p in places if not p.endswith(".md")} <= held <= places


def test_the_bill_says_what_the_wheel_holds_and_needs(made: tuple[Path, Path]) -> None:
    from cyclonedx.schema import SchemaVersion
    from cyclonedx.validation.json import JsonStrictValidator

    text = made[1].read_text(encoding="utf-8")
    validator = JsonStrictValidator(SchemaVersion.V1_6)
    assert validator.validate_str(text) is None
    assert validator.validate_str(text.replace('"components"', '"compnents"')) is not None
    bill = json.loads(text)
    parts = {part["bom-ref"]: part for part in bill["components"]}
    with zipfile.ZipFile(made[0]) as archive:
        names = archive.namelist()
        metadata = next(archive.read(n) for n in names if n.endswith(".dist-info/METADATA"))
    asked = message_from_bytes(metadata).get_all("Requires-Dist")
    told, held = (
        [p["value"] for q in parts.values() for p in q.get("properties", ()) if p["name"] == name]
        for name in ("pkgen:requires", "pkgen:holds")
    )
    assert (
        sorted(map(plain, told))
        == sorted(plain(a) for a in asked if not a.startswith("pkgen-lag["))
        and len(told) > 10
    )
    assert parts["needed:sympy"]["scope"] == "required"
    assert parts["needed:pygls"]["scope"] == "optional"
    # Where there is a licence in the wheel that is not ours, there is something of others.
    ours = ("pkgen_runtime/LICENSE",)
    licences = {n for n in names if "LICENSE" in n and ".dist-info/" not in n and n not in ours}
    assert licences and licences <= set(held)
    sha256 = subprocess.run(["sha256sum", made[0]], capture_output=True, text=True).stdout.split()[
        0
    ]
    assert bill["metadata"]["component"]["hashes"] == [{"alg": "SHA-256", "content": sha256}]


def plain(requirement: str) -> str:
    return requirement.replace(" ", "").replace('"', "'")


def test_versions_of_what_is_held_are_those_of_the_tools() -> None:
    sys.path.insert(0, str(ROOT / TOOL))
    try:
        import sbom
    finally:
        sys.path.remove(str(ROOT / TOOL))
    held = {one.name: one for one in sbom.HELD}
    text = (ROOT / "tools/vendor.py").read_text()
    assert f'"uplot",\n        "{held["uplot"].version}"' in text
    font = (ROOT / "addons/pages/pkgen_pages/explain/fonts/README.md").read_text()
    assert f"STIX Math {held['STIX Math'].version}" in font
