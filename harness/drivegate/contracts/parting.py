"""Where two runs of one scenario part: the first step at which their commands are not the same."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.catalogue import contract_of
from drivegate_cases.scenario.scenario import Scenario

SEED_IN_RESET: Final = "if the controller draws random numbers, seed them in reset"
"""What to do about the most common reason why two runs of one scenario differ."""
_FEWEST_DIGITS: Final = 3
_MOST_DIGITS: Final = 17


@dataclass(frozen=True)
class Parting:
    """The first step at which two runs of a scenario differ."""

    step: int
    """Number of the step, from 0."""
    time: float
    """Its simulated time (s)."""
    output: tuple[str, str]
    """The first number of the command that differs: its name and unit."""
    again: float
    first: float
    """That number in the repetition and in the first run, in SI units."""

    def __str__(self) -> str:
        """State the step, its time and both numbers, with as many digits as it takes to distinguish them."""
        name, unit = self.output
        return (
            f"differs from step {self.step} on, at {self.time:g} s: "
            f"{name} {' against '.join(_distinguished(self.again, self.first))} {unit}"
        ).rstrip()


def empty_commands(scenario: Scenario) -> NDArray[Any]:
    """Return empty rows for the command of every step of a run."""
    return np.zeros(scenario.control_periods, contract_of(scenario.drive).layout.command)


def parting_of(scenario: Scenario, again: NDArray[Any], first: NDArray[Any]) -> Parting | None:
    """Find where the commands of a repetition part from those of the first run, bit for bit."""
    outputs = contract_of(scenario.drive).outputs
    differs = np.stack([again[name].view(np.int64) != first[name].view(np.int64) for name in outputs])
    steps = np.flatnonzero(differs.any(axis=0))
    if steps.size == 0:
        return None
    step = int(steps[0])
    output = tuple(outputs)[int(np.argmax(differs[:, step]))]
    numbers = (float(again[output][step]), float(first[output][step]))
    return Parting(step, step * scenario.control_period_s, outputs[output], *numbers)


def _distinguished(one: float, other: float) -> tuple[str, str]:
    for digits in range(_FEWEST_DIGITS, _MOST_DIGITS + 1):
        texts = f"{one:.{digits}g}", f"{other:.{digits}g}"
        if texts[0] != texts[1]:
            break
    return texts
