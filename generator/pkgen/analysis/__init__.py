"""What pkgen measures of methods on a model: which is cheapest, and where each holds.

chart      error against cost for every method
choose     the cheapest method for the accuracy that a scene asks for
stability  the largest stable step of each method, found and predicted

Called by `cli` alone. Uses compiled models (`compiler`) and runs of them (`run`).
"""
