"""`pkgen explain` and `--dump`: equations and their proofs as text.

The input is the results of the compiler's stages. Only `cli` calls this package.
"""
