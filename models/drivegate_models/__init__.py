"""Plant, sensors, reference controllers and steady states.

This is the lowest layer: it imports no other package of the distribution.
"""
