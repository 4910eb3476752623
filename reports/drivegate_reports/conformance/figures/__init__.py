"""Figures of that page: recorded runs, scripts, margins."""
