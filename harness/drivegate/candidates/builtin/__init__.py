"""Controllers that are included, correct and faulty."""
