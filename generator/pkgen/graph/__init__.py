"""The expression graph, and the domains in which it is evaluated.

Nodes are integers in one append-only graph, and equal nodes are shared. Nodes can be
differentiated, put in normal form, and evaluated in floats, intervals (`ranges`), balls, and modulo
primes (`residues`). The package contains no mechanics. `middle`, `back` and `explain` call it.
"""
