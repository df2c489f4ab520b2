"""`pkgen explain --html`: equations, proofs and reductions with formulas in MathML."""
