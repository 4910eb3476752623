"""The contract of a current reference and an advance angle, once a control period."""
