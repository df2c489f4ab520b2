"""From the text of a model to a checked Model: `parse`, then `check`."""
