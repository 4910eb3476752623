"""Whether a kept result is unchanged, and who signed it."""
