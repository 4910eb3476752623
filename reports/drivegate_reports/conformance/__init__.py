"""The page of `drivegate check`."""
