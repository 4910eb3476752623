"""What happened in a run of the `current` contract, in words."""
