"""Candidates of machine code: C, shared libraries, and functions that numba compiles."""
