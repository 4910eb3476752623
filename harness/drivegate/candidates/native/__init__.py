"""Compiled controllers: C sources, shared libraries, and functions for numba."""
