"""The signals between harness and controller, with one folder for each contract."""
