"""Derives a model's equations, with constraints, first-order variables, events and switches."""
