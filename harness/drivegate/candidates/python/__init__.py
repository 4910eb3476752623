"""Controllers that are Python classes."""
