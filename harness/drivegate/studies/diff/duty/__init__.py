"""Two candidates that answer with duty ratios, step by step."""
