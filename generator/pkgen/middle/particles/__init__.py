"""Finds the particles of a model: masses and places with T = sum of m/2 |r'|^2."""
