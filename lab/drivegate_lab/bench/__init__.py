"""How fast drivegate is on this machine."""
