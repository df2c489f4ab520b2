"""`pkgen stability`: where each method fails, predicted and measured.

plan      options -> axis, methods, duration, settings
system    a compiled model: its kernels, and steps of any method (pk/stability.h)
ask       questions -> answers, by
  reference  the motion itself        points     a method's run, and its class
  rest       equilibria and modes     near       motions near an equilibrium
  orbits     closed orbits (unknowns) distances  motions that return, part or are elsewhere
  modes      of small motions about an equilibrium
method    one step on the linear oscillator -> its limit, its angle of rotation, its poles
predict   equilibria x method -> lines over the map
measure   the points of the map; each prediction measured on the model
misses    disagreements between predictions and measurements, in sentences
draw, page, text                     the picture, the page, the summary
"""
