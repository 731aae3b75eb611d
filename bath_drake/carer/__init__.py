"""A carer who washes the back with a marker in the hand: for filming (pure).

Nothing in the loop imports this: it is what a recording shows, and its truth.
"""
