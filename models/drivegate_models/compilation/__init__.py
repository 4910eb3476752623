"""Compilation and caching of kernels, and calls of compiled code by address."""
