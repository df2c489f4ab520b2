"""A model as one HTML file that moves in any browser: `page/` is the page, which WebAssembly of the
model and of the runtime (pkgen.back.wasm) drives."""

COMMANDS = """
Make something of it
  show        MODEL.lag [-o FILE.html]     a live page, for any browser
"""
