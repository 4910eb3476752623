"""Verification and benchmarking harness for controllers of permanent-magnet brushless drives.

This is the only public package of the distribution. Importing it is cheap: nothing heavy is loaded
until it is used.
"""

from drivegate.conformance import conformance_tests
from drivegate_models.signals import Command, Nameplate, Sense

__all__ = ["Command", "Nameplate", "Sense", "__version__", "conformance_tests"]

__version__ = "0.1.0"
