"""Closed forms and motions of rigid and constrained bodies, derived by hand, without pkgen.

`integrate` extrapolates the midpoint rule; `attitude` has quaternions as matrices; the others are a
system each. Newton's and Euler's laws where the models have Lagrange's, so that agreement says
something.
"""
