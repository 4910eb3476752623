"""One run of a controller that answers with duty ratios, and its record."""
