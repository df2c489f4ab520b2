"""A Python wheel of one model: a shared library, a description, and model.py, which uses both."""
