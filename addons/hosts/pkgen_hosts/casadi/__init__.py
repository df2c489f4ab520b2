"""Exports a model as external functions for CasADi."""
