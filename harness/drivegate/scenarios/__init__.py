"""Scenarios: plain ones, what may happen in them, what is fair, and how they become simpler."""
