"""Operating maps."""
