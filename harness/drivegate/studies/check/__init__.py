"""Checks of several candidates into one folder."""
