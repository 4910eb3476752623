"""A motor and its drive as a document."""
