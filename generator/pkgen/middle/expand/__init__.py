"""Expands expressions of a model into nodes of the graph, with families unrolled."""
