"""Figures of that page: recorded runs, scripts, margins.

Of each, `draw` makes the figure, to be called in `house_style`. `alternative` describes it in words, for who cannot see
it, and the caption states what it shows and under which conditions.
"""
