"""Field-oriented controllers with the native interface of the contract of duty ratios."""
