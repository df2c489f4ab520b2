"""Predictions about where methods fail, and how each is measured; docs/stability.md shows them."""
