"""`pkgen chart`: accuracy against cost, by every method that applies to a model.

reference  states along the motion beyond double precision, checked against other runs
rows       output rows of runs, and their differences
errors     definitions of the error of a run
spectrum   frequencies along the motion, from which the stability limit of each method follows
sweep      points: runs of every method at several steps or tolerances, measured in C
search     the loosest setting of a method that keeps an accuracy, as slightly finer settings do
answer     the cheapest method and its setting for each accuracy
picture    a picture of six methods and the answers;  draw: pictures of all methods
table      the points as CSV;  page: the HTML page
long       drifts of constants of motion in runs of 10 to 10^7 fixed steps
chart      makes a Chart, the record of all measurements of a compiled model
"""
