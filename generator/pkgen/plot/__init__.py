"""Pictures of what a run leaves: a table, what of it is drawn, and two who draw it, on paper and in
a terminal. `style.py` is the look of every picture that pkgen makes."""
