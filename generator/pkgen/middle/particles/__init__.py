"""Finds the particles of a model: masses m and positions r with T = sum of m/2 |r'|^2."""
