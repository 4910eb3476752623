"""The very bytes of a target: an image for Cortex-M, run instruction by instruction."""
