"""Predictions about where methods fail, and how each is measured; docs/stability.md shows them."""

from mpmath import mp

mp.dps = 15  # other tests leave other precisions; the page shows twelve digits
