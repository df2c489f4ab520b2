// Starts `pkgen lsp` where a .lag file is opened; all that it knows comes from there.
const { workspace, window } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

async function activate() {
  const command = workspace.getConfiguration("pkgen").get("path") || "pkgen";
  const server = { command, args: ["lsp"] };
  const options = { documentSelector: [{ language: "lag" }] };
  client = new LanguageClient("pkgen", "pkgen", server, options);
  try {
    await client.start();
  } catch (error) {
    window.showWarningMessage(
      `pkgen: no language server (${error.message}). Install it by: pip install 'pygls>=2', ` +
        "or name its place in the setting pkgen.path. Colours are there without it."
    );
  }
}

function deactivate() {
  return client && client.isRunning() ? client.stop() : undefined;
}

module.exports = { activate, deactivate };
