"""The language server: serves the analysis of a text by the Language Server Protocol.

pygls implements the protocol; each request analyses the text again, within milliseconds. If the
equations are derived quickly, all checks of `pkgen check` run after each change; otherwise only
when a text is opened or saved.
"""

from __future__ import annotations

import logging
import os
import signal
import sys
import time
from collections.abc import Callable
from functools import lru_cache
from typing import BinaryIO

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer

from pkgen import limits
from pkgen.source import Diagnostic, ModelError, Source, Span
from pkgen.system.children import ENDS
from pkgen.system.exits import INTERRUPTED
from pkgen.system.resources import ResourcesExceeded, bounded
from pkgen.version import __version__

from . import propose
from .layout import laid_out
from .look import Text

QUICK = 0.2  # If deriving the equations takes fewer seconds, they are derived after each change.
MOST_BYTES = 1 << 26  # Bytes of the longest accepted message.
LONGEST = 10.0  # Most CPU seconds for the analysis of a text.
KINDS = {
    "statement": lsp.CompletionItemKind.Keyword,
    "clause": lsp.CompletionItemKind.Keyword,
    "name": lsp.CompletionItemKind.Variable,
    "function": lsp.CompletionItemKind.Function,
    "unit": lsp.CompletionItemKind.Unit,
    "method": lsp.CompletionItemKind.Method,
    "member": lsp.CompletionItemKind.Field,
}
SEVERITIES = {
    "error": lsp.DiagnosticSeverity.Error,
    "warning": lsp.DiagnosticSeverity.Warning,
}

server = LanguageServer("pkgen", __version__)
_seconds: dict[str, float] = {}  # CPU seconds to derive the equations, by URI


@lru_cache(maxsize=32)
def _looked(path: str, text: str) -> Text:
    return Text(path, text)


def _text(uri: str) -> Text:
    document = server.workspace.get_text_document(uri)
    return _looked(document.path or uri, document.source)


# ---- places


def _lines(source: Source) -> list[str]:
    return _split(source.text)


@lru_cache(maxsize=4)
def _split(text: str) -> list[str]:
    return [f"{line}\n" for line in text.split("\n")]


def _position(source: Source, offset: int) -> lsp.Position:
    line, column = source.position(offset)
    place = lsp.Position(line - 1, column - 1)
    return server.workspace.position_codec.position_to_client_units(_lines(source), place)


def _range(source: Source, span: Span) -> lsp.Range:
    return lsp.Range(_position(source, span.start), _position(source, span.end))


def _offset(source: Source, position: lsp.Position) -> int:
    lines = source.text.split("\n")
    if position.line >= len(lines):
        return len(source.text)
    place = server.workspace.position_codec.position_from_client_units(_lines(source), position)
    before = sum(len(line) + 1 for line in lines[: position.line])
    return before + min(place.character, len(lines[position.line]))


def _edits(source: Source, changes: list[tuple[Span, str]]) -> list[lsp.TextEdit]:
    return [lsp.TextEdit(_range(source, span), text) for span, text in changes]


# ---- errors and warnings


def _findings(uri: str, all_of_them: bool) -> list[Diagnostic]:
    text = _text(uri)
    if not all_of_them and _seconds.get(uri, 0.0) > QUICK:
        return text.findings()
    began = time.process_time()
    try:
        with bounded(LONGEST, limits.MEMORY_BYTES):
            found = text.all_findings()
    except ResourcesExceeded as error:
        return [Diagnostic(str(error), Span(0, 1), "", "warning")]
    finally:
        _seconds[uri] = time.process_time() - began
    return found


def _publish(uri: str, all_of_them: bool = False) -> None:
    text = _text(uri)
    source = text.source
    found = [
        lsp.Diagnostic(
            range=_range(source, d.span),
            message=f"{d.message}\n{d.help}" if d.help else d.message,
            severity=SEVERITIES[d.severity],
            source="pkgen",
        )
        for d in _findings(uri, all_of_them)[: limits.DIAGNOSTICS]
    ]
    version = server.workspace.get_text_document(uri).version
    params = lsp.PublishDiagnosticsParams(uri=uri, version=version, diagnostics=found)
    server.text_document_publish_diagnostics(params)


@server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
def _opened(params: lsp.DidOpenTextDocumentParams) -> None:
    _publish(params.text_document.uri, all_of_them=True)


@server.feature(lsp.TEXT_DOCUMENT_DID_SAVE)
def _saved(params: lsp.DidSaveTextDocumentParams) -> None:
    _publish(params.text_document.uri, all_of_them=True)


@server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
def _changed(params: lsp.DidChangeTextDocumentParams) -> None:
    _publish(params.text_document.uri)


@server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
def _closed(params: lsp.DidCloseTextDocumentParams) -> None:
    uri = params.text_document.uri
    _seconds.pop(uri, None)
    server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))


# ---- requests about a position


def _at(params: lsp.TextDocumentPositionParams) -> tuple[Text, int]:
    text = _text(params.text_document.uri)
    return text, _offset(text.source, params.position)


@server.feature(lsp.TEXT_DOCUMENT_HOVER)
def _hover(params: lsp.HoverParams) -> lsp.Hover | None:
    text, offset = _at(params)
    found = text.hover(offset)
    if found is None:
        return None
    said = lsp.MarkupContent(lsp.MarkupKind.Markdown, found[1])
    return lsp.Hover(said, _range(text.source, found[0]))


@server.feature(lsp.TEXT_DOCUMENT_DEFINITION)
def _definition(params: lsp.DefinitionParams) -> lsp.Location | None:
    text, offset = _at(params)
    token = text.token_at(offset)
    at = text.declared_at(str(token), text.statement_at(offset)) if token is not None else None
    return lsp.Location(params.text_document.uri, _range(text.source, at)) if at else None


@server.feature(lsp.TEXT_DOCUMENT_REFERENCES)
def _references(params: lsp.ReferenceParams) -> list[lsp.Location]:
    text, offset = _at(params)
    uri = params.text_document.uri
    return [lsp.Location(uri, _range(text.source, span)) for span, _ in propose.uses(text, offset)]


@server.feature(lsp.TEXT_DOCUMENT_RENAME)
def _rename(params: lsp.RenameParams) -> lsp.WorkspaceEdit:
    text, offset = _at(params)
    try:
        changes = propose.renamed(text, offset, params.new_name)
    except propose.Refused as error:
        raise JsonRpcInvalidParams(message=str(error)) from None
    return lsp.WorkspaceEdit({params.text_document.uri: _edits(text.source, changes)})


@server.feature(
    lsp.TEXT_DOCUMENT_COMPLETION, lsp.CompletionOptions(trigger_characters=[".", "[", " "])
)
def _completion(params: lsp.CompletionParams) -> lsp.CompletionList:
    text, offset = _at(params)
    found = propose.proposals(text, offset)
    items = [lsp.CompletionItem(p.label, kind=KINDS[p.kind], detail=p.detail) for p in found]
    return lsp.CompletionList(is_incomplete=False, items=items)


@server.feature(lsp.TEXT_DOCUMENT_INLAY_HINT)
def _inlay_hints(params: lsp.InlayHintParams) -> list[lsp.InlayHint]:
    text = _text(params.text_document.uri)
    first, last = params.range.start.line, params.range.end.line
    places = ((_position(text.source, at), unit) for at, unit in text.inlays())
    shown = ((place, unit) for place, unit in places if first <= place.line <= last)
    return [lsp.InlayHint(place, unit, kind=lsp.InlayHintKind.Type) for place, unit in shown]


@server.feature(
    lsp.TEXT_DOCUMENT_CODE_ACTION,
    lsp.CodeActionOptions(code_action_kinds=[lsp.CodeActionKind.QuickFix]),
)
def _code_actions(params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
    uri = params.text_document.uri
    text = _text(uri)
    start, end = (_offset(text.source, p) for p in (params.range.start, params.range.end))
    here = [d for d in text.findings() if d.span.start <= end and start <= max(d.span.end, 1)]
    return [
        lsp.CodeAction(
            title=f"write {instead.strip()}",
            kind=lsp.CodeActionKind.QuickFix,
            edit=lsp.WorkspaceEdit({uri: _edits(text.source, [(span, instead)])}),
        )
        for finding in here
        for span, instead in propose.repairs(text, finding)
    ]


@server.feature(lsp.TEXT_DOCUMENT_FORMATTING)
def _formatting(params: lsp.DocumentFormattingParams) -> list[lsp.TextEdit] | None:
    source = _text(params.text_document.uri).source
    try:
        made = laid_out(source)
    except ModelError:
        return None  # The diagnostics already display the lexical errors of this text.
    whole = Span(0, len(source.text))
    return [] if made == source.text else _edits(source, [(whole, made)])


@server.feature(lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
def _symbols(params: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
    text = _text(params.text_document.uri)
    found = []
    for statement in text.lexed:
        if len(statement.tokens) > 1 and statement.tokens[1].type == "NAME":
            name = statement.tokens[1]
            of = _range(text.source, statement.span)
            at = _range(text.source, Span(name.start_pos, name.end_pos))
            kind = lsp.SymbolKind.Variable
            if statement.keyword in ("model", "scene", "sample", "event", "body", "joint"):
                kind = lsp.SymbolKind.Namespace
            elif statement.keyword not in _DECLARE:
                continue
            found.append(lsp.DocumentSymbol(str(name), kind, of, at, detail=statement.keyword))
    return found


_DECLARE = ("param", "size", "const", "let", "observe", "conserve", "coord", "input", "state")
_DECLARE += ("rotation", "constraint", "rolling", "memory")


class _Line(logging.Formatter):
    """Formats errors of the protocol in one line, without a traceback."""

    def format(self, record: logging.LogRecord) -> str:
        error = record.exc_info[1] if record.exc_info else ""
        said = " ".join(f"{record.getMessage()} {error}".split("Traceback")[0].split())
        return f"pkgen lsp: {said[:300]}"


class _Input:
    """Standard input. Messages whose declared length exceeds MOST_BYTES are not read."""

    def __init__(self, stream: BinaryIO) -> None:
        self.stream = stream

    def readline(self) -> bytes:
        line = self.stream.readline(MOST_BYTES)
        name, _, length = line.partition(b":")
        if name.lower() == b"content-length" and len(length.strip()) > len(str(MOST_BYTES)):
            return b"Content-Length: %d\r\n" % (MOST_BYTES + 1)
        return line

    def read(self, n: int) -> bytes:
        return self.stream.read(n) if n <= MOST_BYTES else b"too long"


def serve() -> None:
    """Serves requests until the editor closes the connection. Output of print() goes to standard
    error, since standard output is for protocol messages. A signal ends the process at once: a
    normal exit would wait for the thread that reads standard input."""
    for number in ENDS:
        signal.signal(number, lambda *_: os._exit(INTERRUPTED))
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    log = logging.StreamHandler()
    log.setFormatter(_Line())
    logging.getLogger("pygls").addHandler(log)
    start: Callable = server.start_io
    start(_Input(sys.stdin.buffer), output)
