"""The expression graph, and the domains in which it is evaluated.

Nodes are integers in one append-only graph, equal ones shared. A node is differentiated, put in
normal form, and evaluated in floats, intervals (`ranges`), balls, and modulo primes (`residues`).
Knows nothing of mechanics. Called by `middle`, `back`, `explain`.
"""
