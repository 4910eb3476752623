"""Operating maps: grids of steady states, of optima, or of what a candidate makes of them."""
