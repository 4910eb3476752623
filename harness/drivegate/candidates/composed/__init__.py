"""A built-in controller some of whose blocks are the user's own."""
