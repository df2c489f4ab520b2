"""`pkgen stability`: where each method fails, predicted and measured.

plan      options -> axis, methods, duration, settings
ask       questions -> answers       the C program (runtime/run/stability) does all numerics
method    one step on the linear oscillator -> its limit, its angle of rotation, its poles
predict   equilibria x method -> lines over the map
measure   the points of the map; each prediction measured on the model
misses    disagreements between predictions and measurements, in sentences
draw, page, text                     the picture, the page, the summary
"""
