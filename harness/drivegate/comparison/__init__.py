"""Candidates side by side: the same runs for all, a ranking by a stated rule, differences with their uncertainty."""
