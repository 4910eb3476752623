"""The steady state at one operating point."""
