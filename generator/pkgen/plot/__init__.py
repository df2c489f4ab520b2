"""Pictures of rows: compose.py makes a picture of a table, draw.py or terminal.py renders it.
`style.py` defines the look of all pictures of pkgen.
"""
