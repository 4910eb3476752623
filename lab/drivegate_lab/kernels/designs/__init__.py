"""Correct controllers of other designs, for the self-test."""
