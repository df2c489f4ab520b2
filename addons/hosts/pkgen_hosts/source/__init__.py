"""A model with the runtime's core as self-contained C sources."""
