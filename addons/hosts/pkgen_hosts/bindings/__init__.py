"""A model for other languages, all of them over the C that live pages call (back/web/live): a Rust
crate, a Julia package, MEX for MATLAB and Octave, a JavaScript module."""
