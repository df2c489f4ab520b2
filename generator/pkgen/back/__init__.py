"""Back ends turn a model into C, WebAssembly and other files. Their input is the table
`kernels.py`, with each kernel's name, outputs and values as nodes of the graph (`targets.py`), and
proved properties of the equations (`facts.py`). A back end is a folder such as `c`, which uses no
other back end."""
