"""`pkgen stability`: the step sizes at which each method fails, predicted and measured.

plan       reads the options: vertical axis, methods, duration, settings
system     a compiled model: its kernels, and steps of any method (pk/stability.h)
ask        numerical experiments on a model; it uses:
  reference  the reference motion      points     a method's run, and its class
  rest       equilibria and modes      near       motions near an equilibrium
  orbits     closed orbits (unknowns)  distances  distances between motions
  modes      modes of small motions about an equilibrium
method     one step on the linear oscillator: its stability limit, rotation angle, poles
predict    predicted step sizes, from equilibria and a method's step on the oscillator
measure    the points of the map; each prediction measured on the model
misses     sentences on disagreements between predictions and measurements
draw, page, text                      the picture, the page, the summary
"""
