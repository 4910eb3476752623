"""The drive of decoupled phases, each on a half-bridge leg of a split supply."""
