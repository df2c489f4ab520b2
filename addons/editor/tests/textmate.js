// Colours texts by the engine of VS Code: of each character the scopes, as JSON.
const fs = require("fs");
const { createRequire } = require("module");
const [folder, grammarFile, textsFile] = process.argv.slice(2);
const need = createRequire(folder + "/");
const oniguruma = need("vscode-oniguruma");
const textmate = need("vscode-textmate");

async function main() {
  const wasm = fs.readFileSync(need.resolve("vscode-oniguruma/release/onig.wasm"));
  await oniguruma.loadWASM(wasm.buffer.slice(wasm.byteOffset, wasm.byteOffset + wasm.length));
  const registry = new textmate.Registry({
    onigLib: Promise.resolve({
      createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
      createOnigString: (text) => new oniguruma.OnigString(text),
    }),
    loadGrammar: async () =>
      textmate.parseRawGrammar(fs.readFileSync(grammarFile, "utf8"), grammarFile),
  });
  const grammar = await registry.loadGrammar("source.lag");
  const found = JSON.parse(fs.readFileSync(textsFile, "utf8")).map((text) => {
    let state = textmate.INITIAL;
    return text.split("\n").flatMap((line) => {
      const { tokens, ruleStack } = grammar.tokenizeLine(line, state);
      state = ruleStack;
      const scopes = new Array(line.length + 1).fill("");
      for (const token of tokens)
        scopes.fill(token.scopes[token.scopes.length - 1], token.startIndex, token.endIndex);
      scopes[line.length] = "";
      return scopes;
    });
  });
  process.stdout.write(JSON.stringify(found));
}
main();
