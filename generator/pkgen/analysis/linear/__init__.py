"""Equilibria, motions along symmetries, and the modes beside them.

system       a compiled model, its kernels        symmetries  found numerically
newton       corrections and deflation            steady      the equations and their region
equilibria   the search                           rest        what it finds
modes        small motions                        report      equilibria as data and text
normal       modes of `--diagnose`
"""
