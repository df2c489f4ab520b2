"""Pictures of rows: a table is composed to a picture, which matplotlib or a terminal renders.
`style.py` defines the look of all pictures of pkgen."""
