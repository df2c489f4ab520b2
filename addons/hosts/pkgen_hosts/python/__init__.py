"""A wheel of one model: its library, its description, and model.py, which has both called."""
