"""Back ends. What one needs of a program is the table `kernels.py`: each kernel's name, outputs
and values as nodes of the graph (`targets.py`), with what is proved of the equations (`facts.py`).
A back end is a folder beside `c`, which turns that into files; none knows another."""
