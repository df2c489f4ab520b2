"""`pkgen explain` and `--dump`: equations and their proofs as text.

This package formats the results of the compiler's stages. Only `cli` calls it.
"""
