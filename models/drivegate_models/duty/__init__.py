"""Controllers of duty ratios."""
