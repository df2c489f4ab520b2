"""`pkgen chart`: accuracy against cost, by every method that applies to a model.

reference  states on the way, known well beyond double precision and checked
errors     what is called the error of a run
spectrum   frequencies along the motion; where they put each method's limit
sweep      points: every method at a row of steps or tolerances, measured in C
search     the loosest settings that keep an accuracy, and not by luck
answer     which method and step is cheapest for an accuracy
picture    six methods and the answers;  draw: all of them;  table: the CSV;  page: the HTML
long       drifts over decades of fixed steps
command    all of it, from the options to the exit code
"""
