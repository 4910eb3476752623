"""Controllers of the contract of current reference and advance angle, for drives of any kind."""
