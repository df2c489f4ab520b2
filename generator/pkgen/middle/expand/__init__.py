"""Expressions of a model as nodes of the graph, families written out."""
