"""Packs a model as one self-contained HTML file: the page of `page/` with all its files inlined.

Nothing is loaded from elsewhere: a policy in the page allows only its own scripts, by their hashes,
and inline styles. Texts of a model are data, which scripts show as text; they are never markup.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Mapping
from pathlib import Path

from pkgen.back.wasm import HERE as WASM

HERE = Path(__file__).parent / "page"
_STYLE = re.compile(r'<link rel="stylesheet" href="([^"]+)">')
_SCRIPT = re.compile(r'<script src="([^"]+)"></script>')
_HEAD, _END = "<head>\n", "</head>"
# Escapes of characters that could end a script element or start a comment in it.
_ESCAPED = str.maketrans(
    {"<": "\\u003c", ">": "\\u003e", "&": "\\u0026", "\u2028": "\\u2028", "\u2029": "\\u2029"}
)


def packed(
    description: Mapping[str, object], wasm: bytes, explained: str = "", style: str = ""
) -> str:
    """Returns the page. `wasm` is compressed by gzip; `explained` is pkgen's HTML on the equations,
    with its `style`."""
    text = (HERE / "index.html").read_text(encoding="utf-8")
    text = _filled(text, "<title>", f"{html.escape(str(description['title']))} – ")
    text = _STYLE.sub(lambda found: f"<style>{_read(found[1])}</style>", text)
    scripts: list[str] = []

    def script(found: re.Match[str]) -> str:
        scripts.append(_read(found[1]))
        return f"<script>{scripts[-1]}</script>"

    text = _SCRIPT.sub(script, text)
    data = json.dumps(description, ensure_ascii=False, allow_nan=False).translate(_ESCAPED)
    text = _filled(text, '<script type="application/json" id="description">', data)
    code = base64.b64encode(wasm).decode("ascii")
    text = _filled(text, '<script type="application/octet-stream" id="wasm">', code)
    text = _filled(text, '<template id="explained">', explained)
    if style:
        text = text.replace(_END, f"<style>{style}</style>\n{_END}", 1)
    return text.replace(_HEAD, _HEAD + _policy(scripts), 1)


def _read(name: str) -> str:
    folder = WASM if name == "engine.js" else HERE
    text = (folder / name).read_text(encoding="utf-8").strip()
    if "</script" in text.lower() or "</style" in text.lower():
        raise AssertionError(f"{name} would end its own element")
    return text


def _filled(text: str, opening: str, content: str) -> str:
    before, found, after = text.partition(opening)
    assert found, opening
    return before + opening + content + after


def _policy(scripts: list[str]) -> str:
    digests = (hashlib.sha256(script.encode()).digest() for script in scripts)
    hashes = " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)
    rules = (
        "default-src 'none'",
        f"script-src {hashes} 'wasm-unsafe-eval'",
        "style-src 'unsafe-inline'",
        "img-src data: blob:",
        "font-src data:",
        "base-uri 'none'",
        "form-action 'none'",
    )
    return f'<meta http-equiv="Content-Security-Policy" content="{"; ".join(rules)}">\n'
