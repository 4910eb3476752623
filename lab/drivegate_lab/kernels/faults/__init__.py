"""Faulty controllers for the self-test, one folder for each contract."""
