"""Kernels are compiled once, and not at all where none are missing."""

from drivegate.gate.warm_up import compile_kernels


def test_no_kind_is_nothing_to_compile() -> None:
    compile_kernels(())
