"""The checks, one module for each family; `drivegate.catalogue` lists them all."""
