"""What is required of one kind of drive: its closed loop, oracle, scenarios and checks; and what its rating asks."""
