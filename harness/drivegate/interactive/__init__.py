"""The commands as functions, for notebooks and test suites."""
