"""Measures methods on a model: which is cheapest, and where each is stable.

chart      error against cost for every method
choose     the cheapest method for the accuracy that a scene requests
stability  the largest stable step of each method, predicted and measured

Called by `cli` alone. Uses compiled models (`compiler`) and runs of them (`run`).
"""
