"""Exports a model as a functional mock-up unit (FMU) of FMI 2 or 3; `c/` has the C for both."""
