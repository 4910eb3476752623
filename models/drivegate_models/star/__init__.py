"""A star-connected machine with an isolated neutral: plant, periodic states, closed loop."""
