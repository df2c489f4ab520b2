"""The extension for VS Code: its files fit each other, its client starts the server; in the long
tests it is packed, and the engine of VS Code colours as the lexer reads."""

from __future__ import annotations

import json
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest
from colours import KINDS, differences
from test_grammars import every_word, texts

import pkgen
from conftest import ROOT

FOLDER = ROOT / "editors/vscode"
PACKAGE = json.loads((FOLDER / "package.json").read_text())
STUBS = """
const Module = require("module"), load = Module._load, said = [];
const config = { get: () => process.argv[2] };
class LanguageClient {
  constructor(...given) { said.push(given); }
  async start() { if (process.argv[2] === "none") throw new Error("ENOENT"); said.push("started"); }
  isRunning() { return said.includes("started"); }
  stop() { said.push("stopped"); }
}
Module._load = (name, ...more) =>
  name === "vscode" ? { workspace: { getConfiguration: () => config },
                        window: { showWarningMessage: (text) => said.push(text) } }
  : name === "vscode-languageclient/node" ? { LanguageClient } : load(name, ...more);
const extension = require(process.argv[1]);
extension.activate().then(() => { extension.deactivate(); console.log(JSON.stringify(said)); });
"""


def tool(name: str) -> str:
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"{name} is missing")
    return found


def npm(folder: Path, *words: str) -> None:
    """Run it; where it reaches no registry the test is skipped."""
    done = subprocess.run([tool("npm"), *words], cwd=folder, capture_output=True, text=True)
    if done.returncode and ("ENOTFOUND" in done.stderr or "network" in done.stderr.lower()):
        pytest.skip("no npm registry can be reached")
    assert done.returncode == 0, done.stderr


def test_the_files_fit_each_other() -> None:
    has = PACKAGE["contributes"]
    assert PACKAGE["version"] == ".".join(pkgen.__version__.split(".")[:3])
    (language,), (grammar,) = has["languages"], has["grammars"]
    assert language["extensions"] == [".lag"] and grammar["language"] == language["id"]
    made = json.loads((FOLDER / grammar["path"]).read_text())
    assert made["scopeName"] == grammar["scopeName"] and made["fileTypes"] == ["lag"]
    json.loads((FOLDER / language["configuration"]).read_text())
    assert (FOLDER / PACKAGE["main"]).exists()
    assert (FOLDER / "LICENSE").read_text() == (ROOT / "LICENSE").read_text()


@pytest.mark.parametrize("path", ["pkgen", "/opt/pkgen", "none"])
def test_the_client_starts_the_server(path: str) -> None:
    command = [tool("node"), "-e", STUBS, FOLDER / "extension.js", path]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (_, _, server, options), *more = json.loads(done.stdout)
    assert server == {"command": path, "args": ["lsp"]}
    assert options == {"documentSelector": [{"language": "lag"}]}
    if path == "none":
        assert "no language server (ENOENT)" in more[0] and "pip install 'pygls>=2'" in more[0]
    else:
        assert more == ["started", "stopped"]


@pytest.mark.long
def test_it_is_packed(tmp_path: Path) -> None:
    folder = tmp_path / "vscode"
    shutil.copytree(FOLDER, folder, ignore=shutil.ignore_patterns("node_modules", "*.vsix"))
    npm(folder, "install", "--no-audit", "--no-fund")
    npm(folder, "run", "package")
    names = zipfile.ZipFile(folder / "pkgen-lag.vsix").namelist()
    wanted = ("package.json", "extension.js", "syntaxes/lag.tmLanguage.json")
    assert {f"extension/{name}" for name in wanted} <= set(names)
    assert any("vscode-languageclient" in name for name in names)


@pytest.mark.long
def test_its_engine_colours_as_the_lexer_reads(tmp_path: Path) -> None:
    node = tool("node")
    npm(tmp_path, "install", "--no-audit", "--no-fund", "vscode-textmate@9", "vscode-oniguruma@2")
    given = [every_word(), *(text for _, text in texts())]
    (tmp_path / "texts.json").write_text(json.dumps(given))
    script = ROOT / "addons/editor/tests/textmate.js"
    grammar = FOLDER / "syntaxes/lag.tmLanguage.json"
    command = [node, script, tmp_path, grammar, tmp_path / "texts.json"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for text, scopes in zip(given, json.loads(done.stdout), strict=True):
        kinds = [KINDS.get(scope, "") for scope in scopes[: len(text)]]
        assert differences(text, kinds) == []
