"""Drives, operating points and published facts, each with its provenance, and the loader for them."""
