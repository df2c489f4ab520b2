"""A model as a functional mock-up unit of FMI 2 or FMI 3: `c/` is the wrapper for both."""
