"""A model with the step of one method and nothing of the runtime: one C file, a folder for
firmware, an Arduino library."""
