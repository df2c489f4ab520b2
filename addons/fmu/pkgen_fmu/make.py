"""Makes a .fmu archive of description, binaries and sources, reproducible to the byte."""

from __future__ import annotations

import hashlib
import uuid
from pathlib import Path

from pkgen.back.archive import archive
from pkgen.back.exported import TARGET_OPTION, Exported, Host
from pkgen.back.host.data import VALUES, interface
from pkgen.back.library import TARGETS, library, named, this_machine
from pkgen.back.runtime import licence

from . import described
from .model_c import model_c
from .variables import variables

HERE = Path(__file__).parent / "c"
VERSIONS = ("3", "2")


def make(model: Exported) -> dict[str, bytes]:
    version = model.options.fmi or VERSIONS[0]
    all_variables = variables(model)
    token = _token(model, version)
    sources = _sources(model, version, token)
    compiled = [path for path in sources if path.endswith(".c")]
    entries: dict[str, bytes] = {}
    if version == "3":
        text = described.fmi3(model, all_variables, token)
        entries["sources/buildDescription.xml"] = described.build(model.name, compiled).encode()
    else:
        text = described.fmi2(model, all_variables, token, compiled)
    entries["modelDescription.xml"] = text.encode()
    asked = model.options.target
    for target in named(asked) if asked else [None]:
        place = target or TARGETS[this_machine()]
        folder = place.fmi3 if version == "3" else place.fmi2
        code = library(sources, f"fmi{version}", target)
        entries[f"binaries/{folder}/{model.name}{place.suffix}"] = code
    entries["documentation/licenses/runtime.txt"] = licence().encode()
    entries["extra/org.pkgen/model.json"] = model.json().encode()
    entries |= {f"sources/{path}": text.encode() for path, text in sources.items()}
    return {f"{model.name}.fmu": archive(entries)}


def _token(model: Exported, version: str) -> str:
    """Returns the FMU's instantiation token (GUID): a hash of the model's description and C. An FMU
    binary refuses a token other than its own."""
    digest = hashlib.sha256(repr((model.json(), version, sorted(model.files.items()))).encode())
    return f"{{{uuid.UUID(bytes=digest.digest()[:16], version=5)}}}"


def _sources(model: Exported, version: str, token: str) -> dict[str, str]:
    """Returns the C by path: the model, the files of c/, and the runtime files that they need."""
    wrapper = interface(model.name, model.own, model.description, VALUES)
    wrapper |= {
        path.name: path.read_text(encoding="utf-8")
        for path in sorted(HERE.iterdir())
        if path.suffix in (".c", ".h") and not path.stem.startswith("fmi")
    }
    for name in (f"fmi{version}.c", f"fmi{version}.h"):
        wrapper[name] = (HERE / name).read_text(encoding="utf-8")
    wrapper["unit_model.c"] = model_c(model, token)
    return model.with_runtime(wrapper)


FMU = Host(
    "fmu",
    "a functional mock-up unit, for model exchange and co-simulation",
    make,
    ".fmu",
    (
        ("--fmi", {"choices": VERSIONS, "help": "version of FMI; default 3"}),
        TARGET_OPTION,
    ),
    tools="a C compiler; of other machines ziglang (pip)",
)
