"""Checks as tests of pytest."""
