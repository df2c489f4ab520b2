"""Exports a model and the step of one method, without the runtime: one C file, a folder for
firmware, or an Arduino library. Unlike the bindings, these exports do not use the runtime, which
allocates memory and has ten times as much code as one method compiled with the model."""
