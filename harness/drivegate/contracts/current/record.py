"""What the checks see of one finished run, and where in it a verdict comes from."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check, Record, Unseen, deciding_stretch
from drivegate.checks.margin import Margin
from drivegate.contracts.current.run import observed_windows
from drivegate_cases.drive.plant import Scales
from drivegate_cases.scenario.circumstance import Circumstance, circumstance
from drivegate_cases.scenario.load import LockedLoad
from drivegate_cases.scenario.profile import Dwell, dwell_torque, dwells, is_after_change
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.loop.observation import WindowObservation
from drivegate_models.units import RADIANS_PER_RPM

_SAME = 1e-6


@dataclass(frozen=True)
class SteadyWindow:
    """A stretch in which convergence is judged."""

    scenario: Scenario
    dwell: Dwell
    """The constant conditions that it belongs to."""
    values: WindowObservation

    @property
    def speed(self) -> float:
        """Speed reference (rad/s)."""
        return self.dwell.speed_rpm * RADIANS_PER_RPM

    @property
    def torque_required(self) -> float:
        """Torque that the load requires, without friction (N m)."""
        return dwell_torque(self.scenario, self.dwell)

    @property
    def is_loaded(self) -> bool:
        """Whether anything drives or holds the shaft besides friction."""
        return isinstance(self.scenario.load, LockedLoad) or self.torque_required != 0.0

    @property
    def is_after_change(self) -> bool:
        """Whether anything has changed before, or the controller has been restarted."""
        return is_after_change(self.scenario, self.dwell)

    @property
    def scales(self) -> Scales:
        """How the plant differs from the nominal drive meanwhile."""
        return self.dwell.scales

    @property
    def has_nominal_supply(self) -> bool:
        """Whether the supply has its nominal voltage."""
        return self.dwell.supply_v == self.scenario.drive.inverter.supply_voltage_v

    @property
    def requires_rated_power(self) -> bool:
        """Whether the load requires the drive's rated power, from a supply of nominal voltage."""
        power = self.torque_required * self.speed
        return self.has_nominal_supply and math.isclose(
            power, self.scenario.drive.rating.rated_power_w, rel_tol=_SAME
        )


@dataclass(frozen=True)
class CurrentRecord(Record):
    """A finished run of a controller that answers with a current reference and an advance angle."""

    run: ClosedLoopRun
    """The observation of the closed loop."""

    @cached_property
    def circumstance(self) -> Circumstance:
        """What is not nominal about the run."""
        return circumstance(self.scenario)

    def nominal_windows(self) -> Iterator[SteadyWindow]:
        """Go through the stretches in which the search is judged, if everything about the run is nominal."""
        if self.circumstance is Circumstance.NOMINAL:
            yield from self.windows()

    def windows(self) -> Iterator[SteadyWindow]:
        """Go through the stretches in which the search is judged."""
        lowest, highest = self.declaration.speed_range_rpm or (0.0, math.inf)
        by_end = {dwell.end: dwell for dwell in dwells(self.scenario)}
        for (_, end), values in zip(observed_windows(self.scenario), self.run.windows, strict=True):
            dwell = by_end[end]
            if (
                dwell.speed_rpm > self.scenario.drive.rating.base_speed_rpm
                and lowest <= dwell.speed_rpm <= highest
            ):
                yield SteadyWindow(self.scenario, dwell, values)


def rated_torque(scenario: Scenario, speed: float) -> float:
    """Return the torque of the drive's rated power at a speed."""
    return scenario.drive.rating.rated_power_w / speed


def unseen_record(declaration: Declaration, scenario: Scenario) -> CurrentRecord:
    """Make the record of a run that has not been made: its windows are known, but not what they show."""
    run: Any = Unseen(windows=tuple(Unseen() for _ in observed_windows(scenario)))
    return CurrentRecord(scenario, run, declaration)


@dataclass(frozen=True)
class _PartialRecord(CurrentRecord):
    """A run of which only some of the steady stretches are shown."""

    shown: Sequence[int] = ()
    """Their places among all of them."""

    def windows(self) -> Iterator[SteadyWindow]:
        for place, window in enumerate(super().windows()):
            if place in self.shown:
                yield window


def judged_window(check: Check, record: CurrentRecord, margin: Margin | None) -> tuple[float, float]:
    """Find the steady stretch that alone gives the same margin; the whole run where none decides."""

    def part(shown: Sequence[int]) -> CurrentRecord:
        return _PartialRecord(
            record.scenario, record.run, record.declaration, record.repeated_digests, shown=shown
        )

    begin = {end: start for start, end in observed_windows(record.scenario)}
    stretches = [(begin[window.dwell.end], window.dwell.end) for window in record.windows()]
    return deciding_stretch(check, record, margin, stretches, part)
