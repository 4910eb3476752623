"""What passes between harness and controller, one folder for each contract."""
