"""`pkgen chart`: accuracy against cost, by every method that applies to a model.

reference  states along the motion, more precise than double, and checked
errors     the definitions of the error of a run
spectrum   frequencies along the motion, and the limit of each method that follows
sweep      points: every method at a row of steps or tolerances, measured in C
search     the loosest settings that keep an accuracy, without luck
answer     which method and step is cheapest for an accuracy
picture    six methods and the answers;  draw: all methods;  table: the CSV;  page: the HTML
long       drifts over decades of fixed steps
chart      all measurements, from a compiled model to a Chart
"""
