"""Comparing controllers that answer with duty ratios."""
