"""Two candidates step by step, up to the first difference."""
