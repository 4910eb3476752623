"""What controllers answer with: one folder for each contract, behind the bundle in `contract`."""
