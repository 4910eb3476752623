"""Scenarios of the `current` contract: fixed and drawn, which are fair, and how they are simplified."""
