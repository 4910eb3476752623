"""A counterexample run again."""
