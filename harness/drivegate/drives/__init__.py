"""What the gate and the studies ask of one kind of drive: its closed loop, oracle, scenarios and checks."""
