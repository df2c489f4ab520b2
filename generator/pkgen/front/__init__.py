"""Turns the text of a model into a checked Model: `parse`, then `check`."""
