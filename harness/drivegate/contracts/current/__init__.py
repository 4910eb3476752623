"""current."""
