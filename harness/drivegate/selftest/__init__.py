"""The harness checked itself: controllers with one known fault, and the checks that must catch them."""
