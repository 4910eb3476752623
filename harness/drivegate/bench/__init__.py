"""How fast drivegate is on this machine, each number beside a check of the result that it belongs to."""
