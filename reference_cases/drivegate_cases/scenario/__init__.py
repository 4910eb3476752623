"""A run as a document: speed, load, supply, sensors, disturbances."""
