"""Controllers that answer with duty ratios."""
