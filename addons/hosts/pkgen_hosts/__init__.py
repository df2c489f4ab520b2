"""Exports a model as a wheel, a crate, an ES module, for Julia, MATLAB, as one C file, as firmware.
"""
