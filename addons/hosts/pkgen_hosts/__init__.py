"""A model for others: a wheel, a crate, an ES module, Julia, MATLAB, one C file, firmware."""
