"""What the controller of a scenario has to follow."""

from typing import Literal, TypeAlias

from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_cases.scenario.scenario import Scenario

Reference: TypeAlias = Literal["speed", "torque"]
"""The speed of the shaft, or the torque where a dynamometer holds the speed."""
FollowedReference: TypeAlias = Literal["speed", "torque", "current"]
"""What a candidate can follow: the q current comes in place of a torque."""


def reference_of(scenario: Scenario) -> Reference:
    """Return what the controller of a scenario has to follow."""
    return "torque" if isinstance(scenario.load, DynamometerLoad) else "speed"
