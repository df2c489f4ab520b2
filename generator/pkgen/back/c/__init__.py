"""Generates C: `lower` turns Equations into statements, `render` turns these into files."""
