"""Back ends turn a model into C, WebAssembly and other files. They use the table of
kernels (`kernels.py`), which gives the name, the outputs and the values of each kernel. The values
are nodes of the expression graph (`targets.py`). They also use proved properties of the equations
(`facts.py`). Each back end is a folder, such as `c`, and imports no other back end."""
