"""Controllers that come along, correct and faulty."""
