"""One run of one controller, in closed loop or after a script, and its record."""
