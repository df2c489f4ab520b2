"""`pkgen explain` and `--dump`: equations and their proofs as text, MathML and HTML.

Reads what the stages hand on. Called by `cli` alone.
"""
