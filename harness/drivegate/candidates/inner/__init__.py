"""Candidates of current references, run on duty ratios through drivegate's own loop of currents."""
