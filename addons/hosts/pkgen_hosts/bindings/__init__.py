"""Bindings of a model for other languages, over back/host: a Rust crate, a Julia package, MEX for
MATLAB and Octave, a JavaScript module."""
