"""The page of `drivegate compare`."""
