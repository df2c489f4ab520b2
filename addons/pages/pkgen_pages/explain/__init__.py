"""`pkgen explain --html`: equations, proofs and simplifications, with formulas in MathML."""
