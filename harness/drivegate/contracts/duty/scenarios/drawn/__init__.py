"""Hypothesis strategies that draw scenarios, one module a theme."""
