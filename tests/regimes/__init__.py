"""Predictions about where methods fail, and how each is measured (results/stability.md)."""

from mpmath import mp

mp.dps = 15  # other tests leave other precisions; the page shows twelve digits
