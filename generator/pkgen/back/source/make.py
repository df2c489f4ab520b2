"""The folder: the model's C, the runtime's, and the description."""

from __future__ import annotations

import json

from ...own import in_c
from ..exported import Exported, Host
from ..runtime import licence

# What a program that integrates a model calls of the runtime.
CALLED = "pk_method_find pk_integrator_init pk_events_init pk_system_linear pk_integrator_reason"


def make(model: Exported) -> dict[str, bytes]:
    files = {**model.files, **model.runtime(CALLED), "LICENSE": licence()}
    if model.own:
        files |= {in_c.FILE: in_c.tables(model.own)}
    files["model.json"] = json.dumps(model.description, indent=1, ensure_ascii=False)
    return {path: text.encode() for path, text in files.items()}


SOURCE = Host("source", "the model and the runtime as C that compiles alone", make)
