"""Parts that any drive is made of: back-EMF, a winding between events, load, energy ledger."""
