"""A controller of duty ratios with perturbed Senses and commands, to test the checks."""
