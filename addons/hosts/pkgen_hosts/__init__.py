"""A model for other programs: a wheel, a crate, an ES module, Julia, MATLAB, one C file, firmware."""
