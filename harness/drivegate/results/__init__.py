"""Verdicts, the result document, and the files that it is compared with."""
