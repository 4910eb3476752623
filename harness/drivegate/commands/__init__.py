"""The commands of the command line: one module each, and the one place that ends them all."""
