"""A PM AC machine, star-connected with sinusoidal back-EMF, on a two-level bridge: plant, fundamental, oracle."""
