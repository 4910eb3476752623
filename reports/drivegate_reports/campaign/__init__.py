"""The page of `drivegate campaign`."""
