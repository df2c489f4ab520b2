"""Makes an npm package: an ES module that runs the model in WebAssembly, with TypeScript types."""

from __future__ import annotations

import gzip
import json
import re

from pkgen.back.exported import Exported, Host
from pkgen.back.host.data import tables
from pkgen.back.runtime import licence
from pkgen.back.templates import filled
from pkgen.back.wasm import HERE as WASM
from pkgen.back.wasm.build import wasm

from .c import HERE
from .names import step


def make(model: Exported) -> dict[str, bytes]:
    of = model.description
    engine = (WASM / "engine.js").read_text(encoding="utf-8").replace('"use strict";\n', "", 1)
    engine = re.sub(r"\n    swarm\(asked\) \{\n.*?\n    \}\n", "", engine, flags=re.DOTALL)
    named = tables(of)
    words = {kind: [json.dumps(q["name"]) for q in rows] for kind, rows in named.items()}
    context = {
        "name": model.name,
        "package": model.name.lower().replace("_", "-"),
        "title": json.dumps(of["title"], ensure_ascii=False),
        "words": words,
        "methods": [json.dumps(m["name"]) for m in of["methods"] if m["applies"] and not m["gsl"]],
        "step": step(of),
        "method": json.dumps(of["run"]["method"]),
    }
    files = {
        "index.js": engine + filled(HERE, "index.js.j2", **context),
        "index.d.ts": filled(HERE, "index.d.ts.j2", **context),
        "package.json": filled(HERE, "package.json.j2", **context),
        "model.js": f"/* What the model is: pkgen describe. */\nexport default {model.json()};\n",
        "LICENSE": licence(),
    }
    code = gzip.decompress(wasm(model.files, model.name, model.own))
    return {**{path: text.encode() for path, text in files.items()}, "model.wasm": code}


JAVASCRIPT = Host(
    "js",
    "an ES module of WebAssembly with types, for npm",
    make,
    tools="clang, lld, wasi-libc, libclang-rt-dev-wasm32",
)
