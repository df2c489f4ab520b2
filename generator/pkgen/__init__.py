"""pkgen: a compiler from Lagrangians to C. `compiler.py` is its architecture on one page."""

__version__ = "0.1.0"
