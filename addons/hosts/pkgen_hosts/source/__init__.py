"""A model with the runtime's core as C sources, which compile alone."""
