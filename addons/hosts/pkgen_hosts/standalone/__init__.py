"""A model with the step of one method, without the runtime: one C file, a folder for firmware, an
Arduino library. They do not use back/host, since the runtime that this calls needs memory, and ten
times the code of one method whose step is compiled with the model."""
