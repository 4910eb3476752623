"""Drives drawn at random: one way to draw, and for each kind of drive a table of what is drawn within which bounds."""
