"""A model as one HTML file that moves in any browser: `page/` is the page; it runs the model and
the runtime as WebAssembly (pkgen.back.wasm)."""

COMMANDS = """
Make something of it
  show        MODEL.lag [-o FILE.html]     a live page, for any browser
"""
