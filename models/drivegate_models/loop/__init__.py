"""The closed loop of controller and plant, with its sensors, schedules and observations."""
