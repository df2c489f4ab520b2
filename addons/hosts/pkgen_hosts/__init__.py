"""Exports a model as a Python wheel, a Rust crate, an ES module, a Julia package, a MEX function,
one C file, sources for firmware, or external functions for CasADi."""
