"""Builds and runs a compiled model: takes settings, returns rows and a report.

`scenes`, `analysis` and `cli` call this package. It uses `compiler` and `system`.
"""
