"""How controllers that answer with a current reference and an advance angle are compared."""
