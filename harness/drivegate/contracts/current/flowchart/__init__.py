"""The judge of FLO-1: the decisions of Fig. 4, step by step."""
