"""`pkgen stability`: where each method fails, predicted and measured.

plan      options -> Plan            what is varied, which methods, which steps
ask       questions -> answers       the C program (runtime/run/stability) does all numerics
method    a method's own map -> its limit, its frequency, its poles
predict   equilibria x method -> lines over the map
measure   the points of the map; each prediction measured on the model
misses    where the two disagree, in sentences
draw, page, text                     the picture, the page, the summary
"""
