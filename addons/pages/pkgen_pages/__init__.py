"""HTML pages: reports of `explain`, of a run, of a chart, of a stability map.

page.py       the style, tables and inline pictures of all pages
explain/      equations typeset as MathML
run.py        `pkgen run --report`
chart.py      the page that `pkgen chart` writes with its pictures
stability.py  the page that `pkgen stability` writes with its pictures
"""
