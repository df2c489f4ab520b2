"""`pkgen lsp`, spoken to as an editor does."""

from __future__ import annotations

import importlib.util
import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from client import LONGEST, Editor, applied

from conftest import MODELS, ROOT, run_pkgen
from pkgen_editor.look import Text
from pkgen_editor.propose import Refused, renamed, repairs

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("pygls") is None, reason="pygls is missing: pip install 'pygls>=2'"
)

TEXT = """\
model swing
param m = 1 [kg] in (0, inf)
param l = 2 [m] in (0, inf)        # length of the rod
param g = 9.81 [m/s^2]
param w = sqrt(g/l)
coord theta [rad]                  # from below
let y = -l*cos(theta)
kinetic m/2*l^2*theta'^2
potential m*g*y
observe p = p_theta/(m*l^2)
observe phase = w*t
scene small
  set l = 1 [m]
  until 2
  method gauss
  record theta, y, p every 0.1
  expect sum(theta^2, i = 1..2) < 1
end
"""


@pytest.fixture(scope="module")
def editor() -> Iterator[Editor]:
    editor = Editor()
    yield editor
    assert editor.close() == 0


@pytest.fixture
def uri(editor: Editor, tmp_path: Path) -> str:
    return editor.open(tmp_path / "swing.lag", TEXT)


def place(part: str, within: str = TEXT, at: int = 0) -> tuple[int, int]:
    offset = within.index(part) + at
    return within.count("\n", 0, offset), offset - within.rfind("\n", 0, offset) - 1


def test_findings_as_one_types(editor: Editor, uri: str) -> None:
    assert editor.findings(uri) == []
    editor.change(uri, TEXT.replace("m*g*y", "m*g"))
    (wrong,) = editor.findings(uri)
    assert wrong["severity"] == 1 and wrong["message"].startswith("unit mismatch: m*g is a force")
    line = place("potential")[0]
    start, end = {"line": line, "character": 10}, {"line": line, "character": 13}
    assert wrong["range"] == {"start": start, "end": end}
    editor.change(uri, TEXT + "conserve c = theta\n")
    assert "is not constant" in editor.findings(uri)[0]["message"]  # which equations show
    editor.change(uri, TEXT.replace("2*l^2", "2*"))
    editor.change(uri, TEXT.replace("= p_theta", "= $"))
    assert "'$' means nothing" in editor.findings(uri)[0]["message"]
    editor.change(uri, "")
    assert editor.findings(uri)[0]["message"].startswith("the file is empty")
    editor.change(uri, "model \0")
    assert "NUL" in editor.findings(uri)[0]["message"]
    editor.change(uri, TEXT)
    assert editor.findings(uri) == []


def test_findings_are_those_of_check(editor: Editor) -> None:
    for case in sorted((ROOT / "tests/generator/wrong").glob("*.lag"))[::6]:
        text = case.read_text(encoding="utf-8")
        uri = editor.open(case, text)
        found = editor.findings(uri)
        lines = [f"{d['range']['start']['line'] + 1}: {d['message']}" for d in found]
        done = run_pkgen("check", case, "--json")
        said = json.loads(done.stdout).get("diagnostics", [])
        said = [d for d in said if d["severity"] == "error"]
        told = [
            f"{d['line']}: {d['message']}" + (f"\n{d['help']}" if d["help"] else "") for d in said
        ]
        assert [x for x in lines if x in told] == told, case.name


def test_hover(editor: Editor, uri: str) -> None:
    def said(part: str, at: int = 0) -> str:
        return editor.at("hover", uri, *place(part, at=at))["contents"]["value"]

    assert said("l*cos") == (
        "**l**: a parameter [m] = 2\n\nlength of the rod\n\n"
        "```lag\nparam l = 2 [m] in (0, inf)\n```"
    )
    assert said("w = sqrt").startswith("**w**: a parameter [1/s] = 2.214723459")
    assert said("theta'").startswith(
        "**theta**: a coordinate [rad] (its rate [rad/s])\n\nfrom below"
    )
    assert said("p_theta") == "**p_theta**: the momentum of theta"
    assert said("sqrt(g").startswith("`sqrt(x)`: the square root")
    assert said("[m/s^2]", 2) == "`[m/s^2]`: an acceleration [m/s^2]"
    assert "expect A = B within" in said("expect")
    assert said("i = 1..2").startswith("**i**: a loop variable")
    assert "adaptive" in said("gauss")
    assert editor.at("hover", uri, 0, 200) is not None  # behind the line's end: its last word
    assert editor.at("hover", uri, 999, 0) is None


def test_definition_and_references(editor: Editor, uri: str) -> None:
    found = editor.at("definition", uri, *place("y\n"))
    line, character = place("y = -l")
    start = {"line": line, "character": character}
    assert found["range"] == {"start": start, "end": {"line": line, "character": character + 1}}
    found = editor.at("definition", uri, *place("p_theta"))
    assert found["range"]["start"]["line"] == place("coord")[0]
    context = {"includeDeclaration": True}
    found = editor.at("references", uri, *place("theta ["), context=context)
    assert len(found) == TEXT.count("theta")
    assert editor.at("definition", uri, *place("until")) is None


def test_rename(editor: Editor, uri: str) -> None:
    edit = editor.at("rename", uri, *place("theta'"), newName="phi")
    made = applied(TEXT, edit["changes"][uri])
    assert made == TEXT.replace("theta", "phi")
    edit = editor.at("rename", uri, *place("i = 1"), newName="k")
    assert applied(TEXT, edit["changes"][uri]) == TEXT.replace("i = 1..2", "k = 1..2")

    def refused(part: str, new: str) -> str:
        line, character = place(part)
        position = {"line": line, "character": character}
        params = {"textDocument": {"uri": uri}, "position": position, "newName": new}
        return editor.answer("textDocument/rename", params)["error"]["message"]

    assert "has a meaning in this model already" in refused("theta'", "y")
    assert "has a meaning in this model already" in refused("y = -l", "p_theta")
    assert "is a word of the language" in refused("y = -l", "param")
    assert "is no name" in refused("y = -l", "a b")
    assert "is no name of this model's own" in refused("until", "a")


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_every_name_of_the_models_can_be_another(path: Path) -> None:
    """All its places are found: the model is right with another name, and the same with the old."""
    whole = path.read_text(encoding="utf-8")
    text, done = Text(path.name, whole), 0
    for name, entry in text.names.items():
        if not entry.span.end or "." in name or "[" in name:
            continue
        edits = renamed(text, entry.span.start, "other")
        made = whole
        for span, new in reversed(edits):
            made = made[: span.start] + new + made[span.end :]
        other = Text(path.name, made)
        assert other.seen.errors == () and len(other.names) == len(text.names)
        with pytest.raises(Refused, match="meaning in this model already"):
            renamed(text, entry.span.start, text.base(name))
        done += 1
    assert done > 4


def test_completion(editor: Editor, uri: str) -> None:
    def offered(text: str) -> set[str]:
        editor.change(uri, text)
        line, column = text.count("\n"), len(text) - text.rfind("\n") - 1
        return {item["label"] for item in editor.at("completion", uri, line, column)["items"]}

    head = TEXT[: TEXT.index("scene")]
    words = offered(head + "po")
    assert {"potential", "draw", "scene"} <= words and not words & {"until", "end", "theta"}
    words = offered(head + "scene a\n  un")
    assert {"until", "expect", "end", "set"} <= words and "param" not in words
    words = offered(head + "let z = 2*t")
    assert {"theta", "l", "sin", "p_theta", "pi", "energy"} <= words and "param" not in words
    assert {"kg", "N", "deg"} <= offered(head + "param q = 2 [")
    assert offered(head + "draw ") == offered(head + "draw r") >= {"rod", "bob"}
    assert offered(head + "draw rod from O ") == {"to"}
    assert {"gauss", "dop853"} <= offered(head + "scene a\n  method ")
    assert {"x", "y", "z"} == offered(head + "let v = [y, y, y]\nlet u = v.")
    assert offered(head + "# the") == set()
    assert {"in"} <= offered(head + "param q = 2 i")
    assert "in" not in offered(head + "let q = i")


def test_units_are_shown(editor: Editor, uri: str) -> None:
    whole = {"start": {"line": 0, "character": 0}, "end": {"line": 99, "character": 0}}
    params = {"textDocument": {"uri": uri}, "range": whole}
    found = editor.ask("textDocument/inlayHint", params)
    assert [(hint["position"]["line"], hint["label"]) for hint in found] == [
        (place("param w")[0], " [1/s]"),
        (place("let y")[0], " [m]"),
        (place("observe p")[0], " [1/s]"),
    ]
    assert found[1]["position"]["character"] == len("let y = -l*cos(theta)")


@pytest.mark.parametrize(
    ("wrong", "title", "right"),
    [
        (("-l*cos(theta)", "-l*cos(thta)"), "write theta", None),
        (("= 1 [kg]", "= 1kg"), "write 1 [kg]", None),
        (("m*g*y", "mg*y"), "write m*g", None),
        (("9.81", "9,81"), "write 9.81", None),
        (("9.81", "9."), "write 9.0", "9.0"),
        (("l^2*theta'^2", "l²*theta'^2"), "write ^2", None),
        (("theta [rad]   ", "theta[rad]    "), "write [rad]", None),
        (("method gauss", "method gaus"), "write gauss", None),
    ],
)
def test_repairs(editor: Editor, uri: str, wrong: tuple, title: str, right: str | None) -> None:
    old, new = wrong
    text = TEXT.replace(old, new, 1)
    editor.change(uri, text)
    assert editor.findings(uri)
    whole = {"start": {"line": 0, "character": 0}, "end": {"line": 99, "character": 0}}
    params = {"textDocument": {"uri": uri}, "range": whole, "context": {"diagnostics": []}}
    found = editor.ask("textDocument/codeAction", params)
    action = next(a for a in found if a["title"] == title)
    made = applied(text, action["edit"]["changes"][uri])
    wanted = TEXT.replace(old, right) if right else TEXT
    assert made.split() == wanted.split()


def test_each_repair_takes_its_finding_away() -> None:
    offered = 0
    for case in sorted((ROOT / "tests/generator/wrong").glob("*.lag")):
        text = Text(case.name, case.read_text(encoding="utf-8"))
        for finding in text.findings():
            for span, instead in repairs(text, finding):
                offered += 1
                whole = text.source.text
                other = Text(case.name, whole[: span.start] + instead + whole[span.end :])
                left = [(d.message, d.span.start) for d in other.findings()]
                assert (finding.message, finding.span.start) not in left, finding.message
                assert span.start < span.end and instead != whole[span.start : span.end]
    assert offered > 40


def test_layout(editor: Editor, uri: str) -> None:
    params = {"textDocument": {"uri": uri}, "options": {"tabSize": 2, "insertSpaces": True}}
    ((edit,), text) = editor.ask("textDocument/formatting", params), TEXT
    assert "until  2" in edit["newText"] and text != edit["newText"]
    editor.change(uri, edit["newText"])
    assert editor.ask("textDocument/formatting", params) == []
    editor.change(uri, "model $")
    assert editor.ask("textDocument/formatting", params) is None


def test_columns_are_those_of_the_protocol(tmp_path: Path) -> None:
    text = "model a # \U0001d714\ncoord θ\nkinetic θ'^2 + \U0001d714\n"
    for encoding, width in (("utf-16", 2), ("utf-8", 4), ("utf-32", 1)):
        editor = Editor((encoding,))
        uri = editor.open(tmp_path / "a.lag", text)
        (wrong,) = (d for d in editor.findings(uri) if "omega" in d["message"])
        start, end = (wrong["range"][key]["character"] for key in ("start", "end"))
        assert end - start == width, encoding
        assert editor.close() == 0


def test_texts_that_are_typed_letter_by_letter(editor: Editor, uri: str) -> None:
    """No state of a text that is being written is one that the server has no answer for."""
    text = (ROOT / "models/heavy_top.lag").read_text(encoding="utf-8")[2000:2600]
    head = TEXT[: TEXT.index("scene")]
    for end in range(0, len(text), 23):
        now = head + text[:end]
        editor.change(uri, now)
        line, column = now.count("\n"), len(now) - now.rfind("\n") - 1
        for method in ("hover", "definition", "completion"):
            editor.at(method, uri, line, column)
        params = {"textDocument": {"uri": uri}, "context": {"diagnostics": []}}
        span = {"start": {"line": line, "character": 0}, "end": {"line": line, "character": column}}
        editor.ask("textDocument/codeAction", {**params, "range": span})
        editor.ask("textDocument/inlayHint", {**params, "range": span})


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it(number: int) -> None:
    editor = Editor()
    editor.process.send_signal(number)
    assert editor.process.wait(LONGEST) == 130


def test_an_editor_that_is_gone_ends_it(tmp_path: Path) -> None:
    editor = Editor()
    editor.open(tmp_path / "a.lag", "model a\n")
    editor.process.stdin.close()
    assert editor.process.wait(LONGEST) in (0, 1)


def test_without_pygls_it_is_told(tmp_path: Path) -> None:
    script = (
        "import sys; from importlib.machinery import PathFinder; find = PathFinder.find_spec\n"
        "PathFinder.find_spec = lambda n, *more: None if n == 'pygls' else find(n, *more)\n"
        "from pkgen.__main__ import main; sys.exit(main(['lsp']))"
    )
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "pkgen: lsp needs pygls 2, which is not here: pip install 'pygls>=2'\n"


def test_a_client_that_errs_gets_no_traceback_and_does_not_end_it(tmp_path: Path) -> None:
    editor = Editor()
    uri = editor.open(tmp_path / "x.lag", TEXT)
    for length in (b"9" * 5000, b"9" * 30, b"%d" % (1 << 40)):
        editor.process.stdin.write(b"Content-Length: " + length + b"\r\n\r\n")
    for body in (b"nonsense", b"[]", b"null", b"{}", b'{"jsonrpc": "2.0", "id": 7}', b"\xff" * 9):
        editor.process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
    params = {"textDocument": {"uri": uri}, "position": {"line": 0, "character": 0}}
    assert "error" in editor.answer("textDocument/rename", {**params, "newName": "a b"})
    assert "error" not in editor.answer("textDocument/hover", params)
    assert editor.close() == 0
    said = editor.process.stderr.read().decode()
    assert "Traceback" not in said and 'File "' not in said
