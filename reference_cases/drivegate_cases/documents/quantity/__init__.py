"""A quantity as people write it: number, unit and the words that say of what it is."""
