"""Rigorous bounds of a motion: `pkgen run --enclose`.

domains.py    evaluation of the graph in balls, in their power series, in complex balls
flow.py       the equations as y' = F(t, y), their Jacobian, exact values of parameters
ask.py        exact numbers from the options, and refusal of unsupported models
apriori.py    a complex neighbourhood that no motion leaves in a step: Picard and Lindelof
step.py       one step: Taylor series, remainder, Lohner's set
enclose.py    steps to the end, repeated with more digits if too many are lost
text.py       rows and report
"""
