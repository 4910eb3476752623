"""The plant over one control period, exact from event to event."""
