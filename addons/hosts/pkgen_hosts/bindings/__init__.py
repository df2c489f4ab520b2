"""Bindings of a model for other languages, all over the C of live pages (back/web/live): a Rust
crate, a Julia package, MEX for MATLAB and Octave, a JavaScript module."""
