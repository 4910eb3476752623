"""How controllers that answer with duty ratios are compared."""
