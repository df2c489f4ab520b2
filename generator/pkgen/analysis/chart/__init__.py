"""`pkgen chart`: accuracy against cost, by every method that applies to a model.

reference  states along the motion beyond double precision, checked against other runs
errors     definitions of the error of a run
spectrum   frequencies along the motion, from which the stability limit of each method follows
sweep      points: runs of every method at several steps or tolerances, measured in C
search     the loosest setting of a method that keeps an accuracy, not by luck
answer     the cheapest method and its setting for each accuracy
picture    six methods and the answers;  draw: all methods;  table: the CSV;  page: the HTML
long       drifts of constants in runs of 10 to 10^7 fixed steps
chart      makes a Chart, with all measurements, of a compiled model
"""
