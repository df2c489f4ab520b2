"""Smaller equations for the same rows: cyclic coordinates, parts that move by themselves."""
