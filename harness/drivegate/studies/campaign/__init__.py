"""Campaigns: grids and drawn drives, many thousands of runs."""
