"""Makes a folder with the C of the model and of the runtime, and the model's description."""

from __future__ import annotations

from pkgen.back.exported import Exported, Host
from pkgen.back.runtime import licence

# The functions of the runtime that a program calls to integrate a model.
CALLED = """#include <pk/pk.h>
pk_method_find pk_integrator_init pk_events_init pk_system_linear pk_integrator_reason
"""


def make(model: Exported) -> dict[str, bytes]:
    files = model.with_runtime({"called.h": CALLED})
    del files["called.h"]
    files |= {"LICENSE": licence(), "model.json": model.json()}
    return {path: text.encode() for path, text in files.items()}


SOURCE = Host("source", "the model and the runtime as C that compiles alone", make)
