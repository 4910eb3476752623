"""Field-oriented control, behind the native interface of the contract of duty ratios."""
