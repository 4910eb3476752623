"""How any page and any figure is made."""
