"""Conformance and comparison reports: figures, tables and the pages that hold them."""
