"""`pkgen linearise`: A, B, C, D beside an equilibrium, a trim or a state of the motion.

linearise    the matrices                      state_space  what others take of them
plots        Bode diagrams, root loci, poles   command      the command and `m.linearise()`
"""

COMMANDS = """
Judge a motion
  linearise   MODEL.lag                    A, B, C, D beside a state of it
"""
