"""Two candidates step by step."""
