"""Checks of a drive without a position sensor."""
