"""Sensors between the plant and its controller: converters of currents and supply, an encoder, Hall switches."""
