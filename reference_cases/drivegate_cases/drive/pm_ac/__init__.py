"""The document of a PM AC drive: a d-q machine on a two-level bridge that is given duty ratios."""
