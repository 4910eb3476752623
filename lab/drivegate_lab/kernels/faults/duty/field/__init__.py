"""Faults that firmware has had in the field: each shows in an operation that is rarely tried."""
