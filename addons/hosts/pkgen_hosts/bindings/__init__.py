"""Bindings of a model for other languages, all over its C interface pk_host.h: a Rust crate, a
Julia package, a MEX function for MATLAB and Octave, a JavaScript module."""
