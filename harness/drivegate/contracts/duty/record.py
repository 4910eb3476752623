"""What the checks see of one finished run of a controller of duty ratios, and where in it a verdict comes from."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check, NotRun, Record, Unseen, deciding_stretch
from drivegate.checks.margin import Margin
from drivegate.checks.means import exact_mean
from drivegate.contracts.duty.current_reference import quadrature_for
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.right_trips import right_trip_s
from drivegate.contracts.duty.run import DutyClosedLoopRun
from drivegate.contracts.duty.scenarios.compared import mirror_image, with_other_dead_time
from drivegate.contracts.duty.scenarios.windows import duty_windows, released_windows
from drivegate_cases.drive.limits import Limits, limits_of
from drivegate_cases.drive.plant import NOMINAL
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_cases.scenario.profile import Dwell
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import IdealSensors
from drivegate_models.pm_ac.plant.drive import PmAcDrive, drifted
from drivegate_models.units import RADIANS_PER_RPM


@dataclass(frozen=True)
class DutyWindow:
    """Means over a stretch in which a steady state is judged."""

    dwell: Dwell
    """The constant conditions that it belongs to."""
    start_s: float
    end_s: float
    """The stretch (s)."""
    speed: float
    """Speed of the shaft (rad/s)."""
    torque: float
    """Electromagnetic torque (N m)."""
    direct: float
    quadrature: float
    """Currents of the rotor frame (A)."""
    voltage: float
    """Peak voltage of a phase that the duty ratios ask for (V)."""
    link: float
    """Voltage of the dc link (V)."""

    @property
    def current(self) -> float:
        """Peak current of a phase, of its fundamental (A)."""
        return math.hypot(self.direct, self.quadrature)

    @property
    def torque_reference(self) -> float | None:
        """What the controller was asked for (N m); None where that was a speed."""
        return self.dwell.torque_reference_nm

    @property
    def speed_reference(self) -> float:
        """Speed that the shaft was asked for, or held at (rad/s)."""
        return self.dwell.speed_rpm * RADIANS_PER_RPM


@dataclass(frozen=True)
class DutyRecord(Record):
    """A finished run with what belongs to it; attributes as of any record, but for the run."""

    # A run of duty ratios has columns of its own; the checks that take this record know no other.
    run: DutyClosedLoopRun
    other_dead_time: DutyRecord | None = None
    """The same run on the drive with another dead time, where there is one to compare with."""
    mirror: DutyRecord | None = None
    """The mirror image of the run, where there is one to compare with."""

    @property
    def document(self) -> PmAcDocument:
        return duty_document(self.scenario.drive)

    @property
    def plant(self) -> PmAcDrive:
        drive: Any = self.drive
        plant: PmAcDrive = drive
        return plant

    def plant_at(self, period: int) -> PmAcDrive:
        """Return the plant with its windings as warm as they are at the start of a control period."""
        thermal = self.document.thermal
        if thermal is None:
            return self.plant
        temperature = float(self.run.column("winding_temperature")[period])
        return drifted(self.plant, thermal.resistance_at(temperature, 1.0), 1.0)

    @property
    def limits(self) -> Limits:
        """What the drive's controllers are judged by."""
        return limits_of(self.document)

    @property
    def follows_current(self) -> bool:
        """Whether the controller gets a q current in place of a torque reference."""
        return self.declaration.follows_current and isinstance(self.scenario.load, DynamometerLoad)

    def quadrature_reference(self, torque: float) -> float:
        """Return the q current (A) that it gets in place of a torque (N·m)."""
        return quadrature_for(self.document, float(torque))

    @property
    def is_nominal(self) -> bool:
        """Whether the plant is the one that the controller knows, and is seen as it is."""
        return self.has_nominal_plant and not self.is_sensed and not self.fails

    @property
    def fails(self) -> bool:
        return self.scenario.failure is not None

    @property
    def has_nominal_plant(self) -> bool:
        """Whether the plant is the one that the controller knows."""
        is_cool = self.scenario.winding_temperature_c is None
        return is_cool and self.scenario.scales == NOMINAL and self.scenario.drift is None

    @property
    def is_sensed(self) -> bool:
        """Whether the controller sees the plant through sensors with errors."""
        disturbed = self.scenario.dropouts or self.scenario.glitches
        return bool(disturbed) or not isinstance(self.scenario.sensors, IdealSensors)

    def periods(self, start_s: float, end_s: float) -> slice:
        """Return the control periods from one time to another (s)."""
        period = self.scenario.control_period_s
        return slice(round(start_s / period), round(end_s / period))

    @property
    def nominal(self) -> tuple[DutyWindow, ...]:
        """The stretches in which a steady state is judged, if the drive is the nominal one."""
        return self.steady if self.is_nominal else ()

    @cached_property
    def windows(self) -> tuple[tuple[Dwell, float, float], ...]:
        """Every dwell that is long enough to settle in, with start and end of its judged stretch (s)."""
        return tuple(duty_windows(self.scenario))

    @cached_property
    def steady(self) -> tuple[DutyWindow, ...]:
        """The stretches in which a steady state is judged: none after a trip that is right."""
        trip = right_trip_s(self.scenario, self.run.commands)
        judged = (window for window in self.windows if trip is None or window[2] <= trip)
        return tuple(self._seen_in(*window) for window in judged)

    @cached_property
    def released(self) -> tuple[DutyWindow, ...]:
        """The stretches in which the torque of a free shaft is judged; their speed is the mean of one that changes."""
        return tuple(self._seen_in(*window) for window in released_windows(self.scenario))

    def _seen_in(self, dwell: Dwell, start: float, end: float) -> DutyWindow:
        rows = self.periods(start, end)
        mean = {name: exact_mean(self.run.column(name)[rows]) for name in _MEANS}
        return DutyWindow(dwell, start, end, voltage=exact_mean(self.run.voltages[rows]), **mean)


_MEANS = ("speed", "torque", "direct", "quadrature", "link")


class _UnseenWindow(DutyWindow):
    """Stretch in which a steady state would be judged: what it shows is not known."""

    def __init__(self, dwell: Dwell, start_s: float, end_s: float) -> None:
        self.__dict__.update(dwell=dwell, start_s=start_s, end_s=end_s)

    def __getattr__(self, name: str) -> Any:
        raise NotRun(name)


class _UnseenDutyRecord(DutyRecord):
    """Record of a run that has not been made."""

    @cached_property
    def steady(self) -> tuple[DutyWindow, ...]:
        """The stretches in which a steady state would be judged."""
        return tuple(_UnseenWindow(*window) for window in self.windows)

    @cached_property
    def released(self) -> tuple[DutyWindow, ...]:
        """The stretches in which the torque of a free shaft would be judged."""
        return tuple(_UnseenWindow(*window) for window in released_windows(self.scenario))


def unseen_duty_record(declaration: Declaration, scenario: Scenario) -> DutyRecord:
    """Make the record of a run that has not been made: its windows are known, but not what they show."""
    run: Any = Unseen()
    other, mirror = (
        None if compared is None else _UnseenDutyRecord(compared, run, declaration)
        for compared in (with_other_dead_time(scenario), mirror_image(scenario))
    )
    return _UnseenDutyRecord(scenario, run, declaration, other_dead_time=other, mirror=mirror)


@dataclass(frozen=True)
class _PartialRecord(DutyRecord):
    """A run of which only some of the steady stretches are shown."""

    shown: tuple[DutyWindow, ...] = ()

    @cached_property
    def steady(self) -> tuple[DutyWindow, ...]:
        return self.shown


def judged_window(check: Check, record: DutyRecord, margin: Margin | None) -> tuple[float, float]:
    """Find the steady stretch that alone gives the same margin; the whole run where none decides."""

    def part(places: Sequence[int]) -> DutyRecord:
        shown = tuple(record.steady[place] for place in places)
        return _PartialRecord(
            record.scenario, record.run, record.declaration, record.repeated_digests, shown=shown
        )

    stretches = [(window.start_s, window.end_s) for window in record.steady]
    return deciding_stretch(check, record, margin, stretches, part)
