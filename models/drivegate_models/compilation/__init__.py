"""How kernels are compiled and kept, and how compiled code is called by address."""
