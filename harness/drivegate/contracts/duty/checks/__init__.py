"""Checks of controllers that answer with duty ratios."""
