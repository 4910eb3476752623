"""Sensors between the plant and its controller: current and voltage converters, an encoder, and Hall switches."""
