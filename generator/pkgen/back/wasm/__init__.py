"""A model as WebAssembly, and the JavaScript that calls it, for live pages and ES modules."""

from pathlib import Path

HERE = Path(__file__).parent
