"""Controllers that are built in, one folder for each contract."""
