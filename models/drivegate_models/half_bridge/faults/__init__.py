"""Faulty controllers, for the self-test."""
