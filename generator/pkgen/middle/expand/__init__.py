"""Converts a model's expressions to nodes of the graph. Each member of a family gets its own
nodes."""
