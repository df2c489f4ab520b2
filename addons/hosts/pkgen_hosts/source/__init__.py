"""Exports a model and the runtime's core as self-contained C sources."""
