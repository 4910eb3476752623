"""Comparing controllers that answer with duty ratios, on one drive."""
