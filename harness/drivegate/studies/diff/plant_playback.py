"""The plant's own state at one step of a recorded run, which sensors may show otherwise."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, pi
from pathlib import Path

from drivegate.candidates.fault import CandidateFault
from drivegate.candidates.python.bridge import PythonController
from drivegate.drives.running import run_scenario
from drivegate.studies.diff.record import commands_of, recorded_rows
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.current.signals import Command, Nameplate, Sense
from drivegate_models.errors import HarnessFault


@dataclass(frozen=True)
class PlantState:
    """What the plant was at the start of a control period."""

    speed: float
    """Speed of the shaft (rad/s)."""
    angle: float
    """Electrical angle, 0 to 2π (rad)."""
    phase_currents: tuple[float, ...]
    """(A)."""
    half_supply_voltage: float
    """Mean of the two half-sources (V)."""


class _Reached(Exception):
    """The playback has come to the step that is requested."""


class _Playback:
    """Gives the recorded commands again and watches the plant as it is."""

    def __init__(self, path: Path, phases: int, step: int) -> None:
        self._blocks = recorded_rows(path, phases, step)
        self._left = step

    def reset(self, nameplate: Nameplate) -> None:
        """Begin at the first command."""
        self._turning = nameplate.pole_pairs * 1.0
        self._period = nameplate.control_period
        self._commands = (row for block in self._blocks for row in commands_of(block).tolist())
        self.angle = 0.0
        self.sense: Sense | None = None

    def step(self, sense: Sense) -> Command:
        """Give the next command, and turn as the closed loop does."""
        if self._left == 0:
            self.sense = sense
            raise _Reached
        self._left -= 1
        turned = self.angle + self._turning * sense.speed * self._period
        self.angle = turned - 2.0 * pi * floor(turned * (0.5 / pi))
        return Command(*next(self._commands))


def plant_at(path: Path, scenario: Scenario, step: int) -> PlantState:
    """Find the plant's state at one step by giving it the recorded commands again."""
    playback = _Playback(path, scenario.drive.machine.phases, step)
    # The sensors stay, since Hall switches commutate the plant.
    plain = scenario.replaced(dropouts=(), glitches=(), current_errors=(), restarts_s=())
    try:
        run_scenario(plain, PythonController(playback), sees_plant=True)
    except CandidateFault as ended:
        sense = playback.sense
        if sense is not None:
            return PlantState(sense.speed, playback.angle, sense.phase_currents, sense.half_supply_voltage)
        raise HarnessFault(f"the recorded commands cannot be played back: {ended.fault.message}") from ended
    raise HarnessFault(f"the recorded run has no step {step}")
