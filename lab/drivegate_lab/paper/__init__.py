"""The page of `drivegate reproduce`: the paper beside what is computed."""
