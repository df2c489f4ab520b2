"""A wheel of one model: its library, its description, and model.py, which calls the library."""
