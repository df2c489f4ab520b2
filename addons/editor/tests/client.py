"""An editor, as far as tests need one: it speaks the protocol to `pkgen lsp` in a process."""

from __future__ import annotations

import json
import subprocess
import sys
from contextlib import suppress
from itertools import count
from pathlib import Path

LONGEST = 60  # s


class Editor:
    def __init__(self, encodings: tuple[str, ...] = ("utf-16",)) -> None:
        command = [sys.executable, "-m", "pkgen", "lsp"]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe)
        self.numbers = count(1)
        self.published: dict[str, list[dict]] = {}
        general = {"positionEncodings": list(encodings)}
        params = {"processId": None, "rootUri": None, "capabilities": {"general": general}}
        self.server = self.ask("initialize", params)
        self.tell("initialized", {})

    def send(self, message: dict) -> None:
        data = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(data) + data)
        self.process.stdin.flush()

    def read(self) -> dict:
        length = 0
        while (line := self.process.stdout.readline()) != b"\r\n":
            if not line:
                raise EOFError(self.process.stderr.read().decode())
            name, _, value = line.decode().partition(": ")
            length = int(value) if name == "Content-Length" else length
        return json.loads(self.process.stdout.read(length))

    def tell(self, method: str, params: dict) -> None:
        self.send({"method": method, "params": params})

    def answer(self, method: str, params: dict) -> dict:
        """The whole answer: with "result" or "error"."""
        number = next(self.numbers)
        self.send({"id": number, "method": method, "params": params})
        while True:
            message = self.read()
            if message.get("method") == "textDocument/publishDiagnostics":
                said = message["params"]
                self.published[said["uri"]] = said["diagnostics"]
            elif message.get("id") == number and "method" not in message:
                return message

    def ask(self, method: str, params: dict):
        answer = self.answer(method, params)
        assert "error" not in answer, answer["error"]
        return answer["result"]

    def open(self, path: Path, text: str) -> str:
        uri = path.as_uri()
        document = {"uri": uri, "languageId": "lag", "version": 1, "text": text}
        self.tell("textDocument/didOpen", {"textDocument": document})
        return uri

    def change(self, uri: str, text: str, version: int = 2) -> None:
        document = {"uri": uri, "version": version}
        params = {"textDocument": document, "contentChanges": [{"text": text}]}
        self.tell("textDocument/didChange", params)

    def findings(self, uri: str) -> list[dict]:
        """What has been said of it, once all that was sent is answered."""
        self.ask("textDocument/documentSymbol", {"textDocument": {"uri": uri}})
        return self.published[uri]

    def at(self, method: str, uri: str, line: int, character: int, **more: object):
        position = {"line": line, "character": character}
        params = {"textDocument": {"uri": uri}, "position": position, **more}
        return self.ask(f"textDocument/{method}", params)

    def close(self) -> int:
        with suppress(BrokenPipeError):
            self.ask("shutdown", None)
            self.tell("exit", None)
        self.process.stdin.close()
        return self.process.wait(LONGEST)


def applied(text: str, edits: list[dict]) -> str:
    """The text with edits made, of ASCII or of UTF-32 columns."""
    lines = text.split("\n")

    def offset(place: dict) -> int:
        return sum(len(x) + 1 for x in lines[: place["line"]]) + place["character"]

    found = [(offset(e["range"]["start"]), offset(e["range"]["end"]), e["newText"]) for e in edits]
    for start, end, new in sorted(found, reverse=True):
        text = text[:start] + new + text[end:]
    return text
