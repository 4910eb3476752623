"""The laboratory: what proves drivegate right, and no candidate's check needs.

Planted faults and correct designs, drives drawn at random, the self-test, the benchmark and the reproduction of the
paper. It lies above all other packages: none of them imports it, and they find it by entry points.
"""
