"""The contract of candidates that command duty ratios: signals, and their layout as binary records."""
