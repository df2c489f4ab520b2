"""Rigorous bounds of a motion: `pkgen run --enclose`.

domains.py    evaluation of expression graphs in ball arithmetic: real, complex, power series
flow.py       the equations as y' = F(t, y), their Jacobian, exact values of parameters
ask.py        exact numbers from the options, and refusal of unsupported models
apriori.py    a complex neighbourhood that no motion leaves in a step (Picard and Lindelof)
step.py       one step: Taylor series, bound of its remainder, Lohner's set
enclose.py    a run of steps, repeated in higher precision if it lost too many digits
text.py       the rows and the report as text
"""
