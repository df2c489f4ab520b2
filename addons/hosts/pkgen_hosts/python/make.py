"""Makes the wheel, reproducible to the byte. Its platform tag has the glibc version it needs."""

from __future__ import annotations

import base64
import hashlib
import keyword
import re
import sys
from collections.abc import Mapping
from pathlib import Path

from pkgen.back.archive import archive
from pkgen.back.exported import TARGET_OPTION, Exported, Host
from pkgen.back.host.data import interface
from pkgen.back.library import TARGETS, Target, library, named, this_machine
from pkgen.back.runtime import licence
from pkgen.system.exits import UsageError

HERE = Path(__file__).parent
_GLIBC = re.compile(rb"\0GLIBC_2\.(\d+)\0")
_LEAST_GLIBC = 5  # manylinux_2_5 is the oldest tag
_TAGS = {
    "windows-x86_64": "win_amd64",
    "macos-x86_64": "macosx_11_0_x86_64",
    "macos-aarch64": "macosx_11_0_arm64",
}
METADATA = """Metadata-Version: 2.1
Name: {name}
Version: {version}
Summary: {summary}
Requires-Python: >=3.8
Requires-Dist: numpy
"""
WHEEL = """Wheel-Version: 1.0
Generator: pkgen {pkgen}
Root-Is-Purelib: false
Tag: {tag}
"""


def make(model: Exported) -> dict[str, bytes]:
    name = model.name
    if keyword.iskeyword(name) or name in sys.stdlib_module_names or name == "numpy":
        raise UsageError(f"'{name}' is a module of Python's: call the model otherwise")
    targets = named(model.options.target) if model.options.target else []
    if len(targets) > 1:
        raise UsageError("--target: a wheel is of one machine")
    target = targets[0] if targets else None
    called = interface(name, model.own, model.description)
    model.method()  # Raises an error now if the method cannot be used, not only after installation.
    code = library(model.with_runtime(called), "pk_host_", target)
    place = target or TARGETS[this_machine()]
    tag = f"py3-none-{platform_tag(code, place)}"
    found = model.description
    version = f"{found['pkgen']}+{found['sha256'][:12]}"
    files = {
        f"{name}/__init__.py": (HERE / "wheel" / "model.py").read_bytes(),
        f"{name}/model.json": model.json().encode(),
        f"{name}/library{place.suffix}": code,
    }
    info = f"{name}-{version}.dist-info"
    summary = found["description"].split("\n")[0] or found["title"]
    files |= {
        f"{info}/METADATA": METADATA.format(name=name, version=version, summary=summary).encode(),
        f"{info}/WHEEL": WHEEL.format(pkgen=found["pkgen"], tag=tag).encode(),
        f"{info}/licenses/LICENSE": licence().encode(),
    }
    files[f"{info}/RECORD"] = _record(files, f"{info}/RECORD").encode()
    return {f"{name}-{version}-{tag}.whl": archive(files)}


def platform_tag(code: bytes, target: Target) -> str:
    """Returns the platform tag of the wheel. For Linux, the tag states the lowest version of glibc
    that has all symbols the code needs."""
    if target.name in _TAGS:
        return _TAGS[target.name]
    newest = max((int(v) for v in _GLIBC.findall(_doubled(code))), default=0)
    machine = target.name.partition("-")[2]
    return f"manylinux_2_{max(newest, _LEAST_GLIBC)}_{machine}"


def _doubled(code: bytes) -> bytes:
    """Doubles each zero byte. Each match of _GLIBC includes the zero bytes at both ends of a
    string; so matches in adjacent strings do not overlap."""
    return code.replace(b"\0", b"\0\0")


def _record(files: Mapping[str, bytes], own: str) -> str:
    lines = []
    for path, data in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        lines.append(f"{path},sha256={digest},{len(data)}")
    return "\n".join([*lines, f"{own},,"]) + "\n"


PYTHON = Host(
    "python",
    "a wheel of this model, for which no compiler is needed where it is installed",
    make,
    ".whl",
    (TARGET_OPTION,),
    tools="a C compiler; of other machines ziglang (pip)",
)
