"""Figures: each module computes a figure's data, in named units, and draws it apart from that."""
