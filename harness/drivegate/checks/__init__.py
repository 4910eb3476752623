"""The checks, one module for each family; `catalogue` lists them all."""
