"""Back ends. Their input is the table `kernels.py`: each kernel's name, outputs and values as nodes
of the expression graph (`targets.py`), and the proved properties of the equations (`facts.py`).
A back end is a folder like `c`, which turns that into files; back ends do not use each other."""
