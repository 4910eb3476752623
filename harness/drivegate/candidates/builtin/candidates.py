"""The candidates that come with drivegate, and what they declare of themselves."""

from math import pi, radians
from types import MappingProxyType
from typing import Final

from drivegate.candidates.declaration import Declaration, FlowchartProfile

BUILTIN_CANDIDATES: Final = MappingProxyType(
    {
        "reference": Declaration(estimates_power=True),
        "published": Declaration(
            flowchart=FlowchartProfile(
                speed_tolerance=5 * pi / 30,
                power_tolerance=0.0,
                power_tolerance_fraction=0.001,
                step=radians(1),
                period=0.1,
            ),
            estimates_power=True,
        ),
        "initial": Declaration(estimates_power=True),
    }
)
"""Declarations by bare name."""
