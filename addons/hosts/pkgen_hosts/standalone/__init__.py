"""A model with the step of one method, without the runtime: one C file, a folder for firmware, an
Arduino library."""
