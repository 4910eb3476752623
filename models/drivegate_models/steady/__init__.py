"""The periodic steady state, and the best that the drive can do."""
