"""`pkgen chart`: accuracy against cost, by every method that applies to a model.

reference  the final state, known well beyond double precision and checked
spectrum   frequencies along the motion; where they put each method's limit
sweep      points: every method at a row of steps or tolerances, measured in C
search     the loosest settings that keep an accuracy, and not by luck
answer     which method and step is cheapest for an accuracy
draw       the pictures;  table: the CSV;  page: the HTML
command    all of it, from the options to the exit code
"""
