"""The one closed loop, and what goes into it and comes out."""
