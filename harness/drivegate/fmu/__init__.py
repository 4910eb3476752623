"""Candidates that are FMUs, for co-simulation by FMI 2.0 or 3.0."""
