"""Campaigns: many runs over grids and drawn drives, kept as a dataset."""
