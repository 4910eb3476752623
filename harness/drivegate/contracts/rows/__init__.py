"""A user's own requirements as checks: where a row is judged, what is measured there, and by how much it is met."""
