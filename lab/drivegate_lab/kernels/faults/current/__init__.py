"""Faulty controllers, and correct ones near a limit, for the self-test."""
