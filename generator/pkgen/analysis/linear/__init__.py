"""Equilibria, motions along symmetries, and the linear equations beside them.

system      a compiled model, its kernels        newton      Newton's method from many starts
symmetries  found numerically                    equilibria  the search
modes       small motions                        report      equilibria as data and text
"""
