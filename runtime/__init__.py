"""The C runtime as package data, so that an installed pkgen finds it."""
