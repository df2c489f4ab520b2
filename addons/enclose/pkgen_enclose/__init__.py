"""Rigorous bounds of a motion: `pkgen run --enclose`.

domains.py    a function of the graph on balls, on their power series, on complex balls
flow.py       the equations as y' = F(t, y), their Jacobian, exact values of parameters
ask.py        exact numbers of the options, and what has no bounds here
apriori.py    a complex neighbourhood that no motion leaves in a step: Picard and Lindelof
step.py       one step: Taylor series, its remainder, Lohner's set
enclose.py    steps to the end, again with more digits where they were lost
text.py       rows and report
"""
