"""Equilibria, motions along symmetries, and the linear equations beside them.

system       a compiled model, its kernels        symmetries  found numerically
newton       corrections and deflation            steady      the equations and their region
equilibria   the search                           rest        what it finds
modes        small motions                        report      equilibria as data and text
linearise    A, B, C, D beside a state            state_space and what others take of them
normal       modes of `--diagnose`                plots       Bode, root loci, poles
"""
