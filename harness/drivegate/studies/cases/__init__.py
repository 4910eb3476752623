"""What comes along to run controllers on."""
