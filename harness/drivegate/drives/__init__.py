"""What the gate and the studies require of one kind of drive: its closed loop, oracle, scenarios and checks."""
