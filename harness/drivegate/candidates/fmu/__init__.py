"""Functional mock-up units of FMI 2 and 3."""
