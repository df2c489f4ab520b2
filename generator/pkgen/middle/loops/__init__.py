"""Equations of families of any length, derived once for a general member."""
