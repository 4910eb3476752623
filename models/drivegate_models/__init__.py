"""Plant, sensors, reference controllers, steady state and calibration of the reference drive.

This is the lowest layer: it imports no other package of the distribution.
"""
