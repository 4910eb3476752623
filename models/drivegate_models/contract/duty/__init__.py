"""The contract of candidates that answer with duty ratios: signals, and their layout as binary records."""
