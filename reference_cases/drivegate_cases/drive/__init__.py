"""A drive as a document: its machine, inverter and rating, and where each value comes from."""
