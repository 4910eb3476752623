"""Candidates: from what a user names to a controller that runs, one folder for each kind."""
