"""Runs of controllers of duty ratios: plain and drawn ones, where they are judged, and what is fair."""
