"""Parts that any drive is made of: cycle and back-EMF, a winding between events, its segments, torque, load, ledger."""
