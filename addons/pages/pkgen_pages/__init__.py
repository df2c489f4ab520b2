"""HTML pages: of `explain`, of a run, of a chart, of a stability map.

page.py         what all pages share: their style, tables, inline pictures
explain/        equations typeset as MathML
run.py          `pkgen run --report`
chart.py        beside the pictures of `pkgen chart`
stability.py    beside the pictures of `pkgen stability`
"""
