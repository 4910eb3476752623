"""Compiled code of faulty controllers and of correct designs."""
