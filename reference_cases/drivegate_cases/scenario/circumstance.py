"""What is not nominal about a run, which decides the requirement that it is judged by."""

from enum import Enum

from drivegate_cases.drive.plant import NOMINAL
from drivegate_cases.scenario.courses import COURSES
from drivegate_cases.scenario.scenario import Scenario


class Circumstance(Enum):
    """Circumstances of a run; the later ones include what is before them."""

    NOMINAL = "nominal"
    """The nominal plant through ideal sensors; load, speed reference and supply may change, the controller restart."""
    PARAMETERS = "parameters"
    """A plant whose parameters are not the nameplate's."""
    SENSORS = "sensors"
    """Sensors that are not ideal."""
    FAULTS = "faults"
    """Signals lost, false encoder edges, unequal halves of the supply, or parameters that drift."""


def circumstance(scenario: Scenario) -> Circumstance:
    is_faulty = any(quantity.role == "fault" and quantity.key(scenario) for quantity in COURSES.values())
    if is_faulty or scenario.dropouts or scenario.glitches:
        return Circumstance.FAULTS
    if scenario.sensors.kind != "ideal" or scenario.current_errors:
        return Circumstance.SENSORS
    if scenario.scales != NOMINAL:
        return Circumstance.PARAMETERS
    return Circumstance.NOMINAL
