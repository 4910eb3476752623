"""The built-in candidates, and what they declare of themselves."""

import re
from math import radians
from types import MappingProxyType
from typing import Final

from drivegate.candidates.declaration import Declaration, FlowchartProfile
from drivegate.candidates.kinds import LABORATORY_PREFIXES
from drivegate_cases.scenario.failure_kind import FAILURE_KINDS
from drivegate_models.units import RADIANS_PER_RPM

BUILTIN_CANDIDATES: Final = MappingProxyType(
    {
        "reference": Declaration(estimates_power=True),
        "published": Declaration(
            flowchart=FlowchartProfile(
                speed_tolerance=5.0 * RADIANS_PER_RPM,
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

DUTY_CANDIDATES: Final = MappingProxyType(
    {
        name: Declaration(detects=FAILURE_KINDS)
        for name in (
            "foc",
            "foc-mtpa",
            "foc-loss-model",
            "foc-loss-search",
            "predictive-flux",
            "direct-torque",
            "load-observer",
        )
    }
    | {"foc-sensorless": Declaration()}
)
"""Declarations of those that answer with duty ratios, by bare name."""

_PREFIXED: Final = re.compile(f"({'|'.join(LABORATORY_PREFIXES)})[a-z0-9-]+")


def is_builtin_name(text: str) -> bool:
    """Return True if a text has the form of the name of a built-in candidate, or one of the laboratory's."""
    return text in BUILTIN_CANDIDATES or text in DUTY_CANDIDATES or _PREFIXED.fullmatch(text) is not None
