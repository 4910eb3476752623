"""The contract of candidates that command a current reference and an advance angle in each control period."""
