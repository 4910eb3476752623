"""What controllers answer with: one folder for each contract, behind the class in `contract`."""
