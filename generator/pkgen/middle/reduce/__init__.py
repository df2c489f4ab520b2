"""Reduces equations without changing the recorded output: cyclic coordinates, separate parts."""
