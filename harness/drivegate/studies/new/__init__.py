"""Templates of candidates, written into a folder."""
