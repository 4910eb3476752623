"""Candidates that replace a block of a built-in controller."""
