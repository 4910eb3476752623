"""Candidates that are programs and talk in lines of JSON."""
