"""A run as plain data: drive, plant, supply, speed reference, load, duration and seed."""

import json
from itertools import pairwise
from math import ulp
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from drivegate_cases.documents.document import Document
from drivegate_cases.documents.packaged import load_named, packaged_names
from drivegate_cases.drive.drive_document import DriveDocument, DriveReference
from drivegate_cases.drive.plant import Scales
from drivegate_cases.drive.rating import HIGHEST_SPEED_RPM, OVER_RATING
from drivegate_cases.scenario.control_periods import on_whole_periods, period_start_s, whole_periods
from drivegate_cases.scenario.courses import COURSES, Drift, stated_profiles
from drivegate_cases.scenario.disturbance import CurrentError, Dropout, Glitch
from drivegate_cases.scenario.failure import Failure
from drivegate_cases.scenario.load import (
    ConstantPowerLoad,
    DynamometerLoad,
    Load,
    LockedLoad,
    VehicleLoad,
)
from drivegate_cases.scenario.piecewise import (
    Profile,
    as_profile,
    breakpoints,
    value_from,
    value_until,
    values_within,
)
from drivegate_cases.scenario.sensors import (
    IDEAL,
    PLAIN,
    Sensors,
    fitted,
    has_edges,
    has_encoder,
    position_of,
    refusal,
    unfitted,
)
from drivegate_cases.scenario.sizes import check_sizes
from drivegate_models.contract.current.signals import Nameplate

LONGEST_CONTROL_PERIOD_S = 0.0005
SHORTEST_CONTROL_PERIOD_S = 1e-6
_HIGHEST_SPEED_RPM = OVER_RATING * HIGHEST_SPEED_RPM
_LATEST_START_S = 1e7
_MOST_TURNS = 10**9
_LEFT_OUT: Final[Any] = None
FOLLOWING_KEYS: Final = ("initial_speed_rpm",)
"""Keys that follow from others where they are left out."""


class Scenario(Document):
    """A run of a candidate against the plant, fully resolved: its drive is in it, not just named."""

    schema_current: ClassVar[int] = 2

    name: str = Field(min_length=1, max_length=200, description="name of the scenario")
    description: str = Field(default="", max_length=2000, description="what the run shows")
    drive: DriveReference = Field(
        description="nominal drive: the name of one, the path of its file, or a table of its keys"
    )
    scales: Scales = Field(
        default_factory=Scales, description="table of how the plant differs from the nominal drive"
    )
    duration_s: float = Field(gt=0.0, le=86400.0, description="length of the run, in seconds")
    control_period_s: float = Field(
        default=_LEFT_OUT,
        ge=SHORTEST_CONTROL_PERIOD_S,
        le=LONGEST_CONTROL_PERIOD_S,
        json_schema_extra={"default": LONGEST_CONTROL_PERIOD_S},
        description="time between two steps of the controller, in seconds",
    )
    seed: int = Field(default=0, ge=0, lt=2**63, description="seed of everything random in the run")
    initial_speed_rpm: float = Field(
        ge=-_HIGHEST_SPEED_RPM,
        le=_HIGHEST_SPEED_RPM,
        description="speed of the shaft at time 0, negative backward, by default the first reference",
    )
    initial_angle_deg: float = Field(
        default=0.0, ge=0.0, lt=360.0, description="electrical angle of the rotor at time 0, in degrees"
    )
    clock_start_s: float = Field(
        default=0.0,
        ge=0.0,
        le=_LATEST_START_S,
        description="what the controller's clock shows at time 0, in seconds",
    )
    turns_before: int = Field(
        default=0,
        ge=-_MOST_TURNS,
        le=_MOST_TURNS,
        description="turns that the shaft has made before time 0 at its initial speed, negative backward",
    )
    winding_temperature_c: float | None = Field(
        default=None,
        ge=-60.0,
        le=400.0,
        description="temperature of the windings at time 0, in degrees Celsius, by default that of the surroundings; "
        "of a drive with [thermal]",
    )
    restarts_s: tuple[float, ...] = Field(
        default=(),
        description="list of times at which the controller is reset while the drive runs on, in seconds",
    )
    speed_rpm: Annotated[
        Profile,
        values_within(
            -_HIGHEST_SPEED_RPM,
            _HIGHEST_SPEED_RPM,
            f"must have speeds of at most {_HIGHEST_SPEED_RPM:g} rpm either way",
        ),
    ] = Field(description="speed reference over time, in rpm, negative backward")
    supply_v: (
        Annotated[Profile, values_within(ulp(0.0), 1e5, "must have voltages above 0 and up to 100000 V")]
        | None
    ) = Field(
        default=None,
        description="voltage of each half of the supply over time, or half the voltage of a link without a tap, in "
        "volts, by default the drive's",
    )
    link_voltage_v: (
        Annotated[Profile, values_within(ulp(0.0), 2e5, "must have voltages above 0 and up to 200000 V")]
        | None
    ) = Field(
        default=None,
        exclude=True,
        description="voltage of the whole link over time, of a drive without a tap, in volts, by default the drive's; "
        "it is stored as supply_v, which is half of it",
    )
    load: Load = Field(description="table of the load on the shaft")
    sensors: Sensors = Field(
        default=IDEAL,
        description="sensors between plant and controller: the name of a kind, or a table of its keys",
    )
    current_errors: tuple[CurrentError, ...] = Field(
        default=(), description="list of tables of current sensors that are wrong, one a phase"
    )
    imbalance: Annotated[Profile, values_within(-0.5, 0.5, "must have shares from -0.5 to 0.5")] | None = (
        Field(
            default=None,
            description="share over time by which the upper half of the supply is above, and the lower half below, its "
            "voltage",
        )
    )
    drift: Drift | None = Field(default=None, description="table of how parameters change during the run")
    dropouts: tuple[Dropout, ...] = Field(default=(), description="list of tables of signals that are lost")
    glitches: tuple[Glitch, ...] = Field(default=(), description="list of tables of false encoder edges")
    failure: Failure | None = Field(
        default=None,
        description="table of what fails for good, of a drive whose controllers give duty ratios",
    )

    @model_validator(mode="before")
    @classmethod
    def _starts_on_the_reference(cls, values: Any) -> Any:
        """Take the first speed reference where no initial speed is given."""
        if not isinstance(values, dict) or "initial_speed_rpm" in values:
            return values
        try:
            written = as_profile(values.get("speed_rpm"))
        except ValueError:
            written = None
        match written:
            case ((_, float() | int() as first), *_) if abs(first) <= _HIGHEST_SPEED_RPM:
                return {**values, "initial_speed_rpm": first}
        # The profile itself is refused, and reported, where it has no valid first speed.
        return {**values, "initial_speed_rpm": 0.0}

    @model_validator(mode="before")
    @classmethod
    def _link_is_two_halves(cls, values: Any) -> Any:
        """Take the half of a link's voltage for that of each half of the supply."""
        if not isinstance(values, dict) or values.get("link_voltage_v") is None:
            return values
        if values.get("supply_v") is not None:
            raise ValueError(
                "the keys 'link_voltage_v' and 'supply_v' state the same voltage; leave one of them out"
            )
        try:
            halves = tuple((time, 0.5 * volts) for time, volts in as_profile(values["link_voltage_v"]))
        except (TypeError, ValueError):
            halves = ()
        # A voltage that is none is refused, and reported, as the key that states it.
        is_right = bool(halves) and all(volts > 0.0 for _, volts in halves)
        return {**values, "supply_v": halves} if is_right else values

    @field_validator("link_voltage_v")
    @classmethod
    def _link_has_no_tap(cls, link: Profile | None, info: ValidationInfo) -> None:
        drive: DriveDocument | None = info.data.get("drive")
        if link is not None and drive is not None and drive.has_split_supply:
            raise ValueError(
                f'must be left out, since the drive\'s kind "{drive.kind}" has a split supply; state the voltage '
                "of each half as supply_v"
            )

    @field_validator("sensors")
    @classmethod
    def _sensors_fit_the_drive(cls, sensors: Sensors, info: ValidationInfo) -> Sensors:
        """Take converters chosen for the drive; a drive that is refused is reported by itself."""
        drive = info.data.get("drive")
        return sensors if drive is None else fitted(sensors, drive)

    @field_validator("control_period_s", mode="before")
    @classmethod
    def _period_is_the_modulators(cls, period: Any, info: ValidationInfo) -> Any:
        """Use the control period of a drive that has a modulator, which no scenario changes."""
        drive: DriveDocument | None = info.data.get("drive")
        own = None if drive is None else drive.control_period_s
        if period is _LEFT_OUT:
            return LONGEST_CONTROL_PERIOD_S if own is None else own
        if own is not None and period != own:
            raise ValueError(f"must be left out or {own!r}, which follows from the drive's carrier")
        return period

    @field_validator("restarts_s")
    @classmethod
    def _restarts_in_order(cls, times: tuple[float, ...]) -> tuple[float, ...]:
        if any(time <= 0.0 for time in times) or any(b <= a for a, b in pairwise(times)):
            raise ValueError("must have times above 0 that increase")
        return times

    @model_validator(mode="after")
    def _keys_fit_together(self) -> Self:
        self._check_whole_periods()
        self._check_profiles_end_in_time()
        self._check_disturbances_end_in_time()
        self._check_load_fits_speed()
        self._check_turned_before()
        self._check_sizes()
        self._check_phases()
        if self.imbalance is not None and not self.drive.has_split_supply:
            raise ValueError(
                f"the key 'imbalance' is for a split supply, but the drive's kind is \"{self.drive.kind}\", whose link "
                "has no tap that halves could differ about"
            )
        self._check_kind()
        if (unfit := refusal(self.sensors, self.drive)) is not None:
            raise ValueError(f"the key 'sensors' does not fit the drive: {unfit}")
        if self.glitches and not has_encoder(self.sensors, self.drive):
            described = "ideal ones" if self.sensors.kind == "ideal" else f"'{self.sensors.kind}'"
            raise ValueError(
                f"the key 'glitches' needs the sensors 'mcs96', or an encoder on a PM AC drive, since {described} "
                "have no encoder"
            )
        return self

    def _check_kind(self) -> None:
        own = f'but this one\'s kind is "{self.drive.kind}"'
        if (others := self.drive.excluded_loads.get(self.load.kind)) is not None:
            raise ValueError(f"the load '{self.load.kind}' is {others}, {own}")
        self._check_sense()
        self._check_slip()
        self._check_position()
        self._check_winding()
        for key, others in self.drive.excluded.items():
            if getattr(self, key):
                raise ValueError(f"the key '{key}' is {others}, {own}; leave it out")
        if (
            self.failure is not None
            and self.failure.kind == "lost-edge"
            and not has_edges(self.sensors, self.drive)
        ):
            raise ValueError(
                "the failure 'lost-edge' needs the sensors 'shunts' with the position 'encoder' or 'hall', or a drive "
                "whose [sensing] states one of them, since an exact position has no edges"
            )

    def _check_position(self) -> None:
        """Refuse a lost position where nothing shows the shaft."""
        if position_of(self.sensors, self.drive) != "none":
            return
        lost = (
            [f"the failure '{self.failure.kind}'"]
            if self.failure and self.failure.kind == "lost-position"
            else []
        )
        lost += ["the dropout of 'speed'" for dropout in self.dropouts if dropout.signal == "speed"]
        if lost:
            raise ValueError(
                f"{lost[0]} needs a sensor on the shaft, but the drive's [sensing] states 'none'"
            )

    def _check_slip(self) -> None:
        """Refuse a magnet that slips where the shaft is not shown by one."""
        if (
            self.failure is not None
            and self.failure.kind == "slip"
            and position_of(self.sensors, self.drive) != "exact"
        ):
            raise ValueError(
                "the failure 'slip' needs the position 'exact', the sensor of a magnet on the shaft, of the drive's "
                "[sensing] and of the sensors"
            )

    def _check_winding(self) -> None:
        """Refuse an initial temperature of windings without thermal data, or outside what they may have."""
        given = self.winding_temperature_c
        thermal = getattr(self.drive, "thermal", None)
        if given is None or "winding_temperature_c" in self.drive.excluded:
            return
        if thermal is None:
            raise ValueError(
                "the key 'winding_temperature_c' is for a drive with [thermal], but this one has none; leave it out"
            )
        if not thermal.ambient_c <= given <= thermal.limit_c:
            raise ValueError(
                f"the key 'winding_temperature_c' is {given:g}, but must be from the drive's ambient_c, "
                f"{thermal.ambient_c:g}, to its limit_c, {thermal.limit_c:g} degrees Celsius"
            )

    def _check_sense(self) -> None:
        if (because := self.drive.one_way_because) is None:
            return
        slowest = {
            "initial_speed_rpm": self.initial_speed_rpm,
            "speed_rpm": min(speed for _, speed in self.speed_rpm),
        }
        for key, speed in slowest.items():
            if speed < 0.0:
                raise ValueError(
                    f"the key '{key}' is {speed:g} rpm, but must have speeds from 0, since {because}"
                )

    def _check_whole_periods(self) -> None:
        if not whole_periods(self.duration_s, self.control_period_s):
            nearest = max(1, round(self.duration_s / self.control_period_s))
            raise ValueError(
                f"the key 'duration_s' is {self.duration_s}, but must be a whole number of control periods "
                f"of {self.control_period_s} s, such as {period_start_s(nearest, self.control_period_s):.12g}"
            )

    def _check_profiles_end_in_time(self) -> None:
        for key, profile in stated_profiles(self):
            if profile[-1][0] > self.duration_s:
                raise ValueError(
                    f"the key '{key}' has a point at {profile[-1][0]} s, "
                    f"but must end within the run's {self.duration_s} s"
                )

    def _check_disturbances_end_in_time(self) -> None:
        ends = {"dropouts": [dropout.end_s for dropout in self.dropouts]}
        ends["glitches"] = [glitch.time_s for glitch in self.glitches]
        ends["restarts_s"] = list(self.restarts_s)
        ends["failure"] = [] if self.failure is None else [self.failure.time_s]
        for key, times in ends.items():
            late = [time for time in times if time > self.duration_s]
            if late:
                raise ValueError(
                    f"the key '{key}' has one that ends at {late[0]:.9g} s, "
                    f"but must end within the run's {self.duration_s} s"
                )

    def _check_sizes(self) -> None:
        speeds = [("speed_rpm", speed) for _, speed in self.speed_rpm]
        added = (self.drift.friction_n_m or ()) if self.drift is not None else ()
        check_sizes(
            self.drive.rating,
            [("initial_speed_rpm", self.initial_speed_rpm), *speeds],
            self.load,
            self.scales,
            max((torque for _, torque in added), default=0.0),
        )

    def _check_phases(self) -> None:
        wrong = [error.phase for error in self.current_errors]
        lost = [dropout.phase for dropout in self.dropouts if dropout.phase is not None]
        for key, phases in (("current_errors", wrong), ("dropouts", lost)):
            if phases and max(phases) > self.drive.machine.phases:
                raise ValueError(
                    f"the key '{key}' names the phase {max(phases)}, but the motor has {self.drive.machine.phases}"
                )
        if len(set(wrong)) < len(wrong):
            raise ValueError("the key 'current_errors' must name each phase at most once")

    def _check_turned_before(self) -> None:
        """Refuse turns that the shaft cannot have made at its initial speed."""
        if self.turns_before and not self.turns_before * self.initial_speed_rpm > 0.0:
            raise ValueError(
                f"the key 'turns_before' is {self.turns_before}, but the shaft turns at "
                f"{self.initial_speed_rpm:g} rpm at first; turns have the sign of that speed"
            )

    def _check_released(self, released_s: float) -> None:
        """Refuse a dynamometer that lets the shaft go after the run, or changes its speed after it has."""
        last = self.speed_rpm[-1][0]
        if released_s >= self.duration_s or last > released_s:
            what = (
                f"the run ends at {self.duration_s} s"
                if last <= released_s
                else f"'speed_rpm' goes on to {last} s"
            )
            raise ValueError(
                f"the key 'load.released_s' is {released_s}, but {what}, and nothing holds the shaft then"
            )

    def _check_load_fits_speed(self) -> None:
        if isinstance(self.load, DynamometerLoad) and self.load.released_s is not None:
            self._check_released(self.load.released_s)
        if isinstance(self.load, LockedLoad):
            if self.initial_speed_rpm != self.speed_rpm[0][1]:
                raise ValueError(
                    f"the key 'initial_speed_rpm' is {self.initial_speed_rpm}, but must be the first speed "
                    f"reference, {self.speed_rpm[0][1]}, since the load is locked to it"
                )
        elif isinstance(self.load, ConstantPowerLoad):
            for time in breakpoints([self.speed_rpm, self.load.factor], self.duration_s):
                for value in (value_until, value_from):
                    if value(self.speed_rpm, time) == 0.0 and value(self.load.factor, time) > 0.0:
                        raise ValueError(
                            f"the key 'speed_rpm' is 0 at {time} s, but must be above 0 wherever a load "
                            "of constant power is drawn"
                        )

    def replaced(self, **changes: Any) -> Self:
        """Make a scenario that differs in a few keys.

        For another drive, the converters are chosen again, and so is a control period that is the drive's or the
        default. With another control period, the run lasts until the next whole number of them.
        """
        drive = changes.get("drive", self.drive)
        if "drive" in changes:
            changes.setdefault("sensors", unfitted(self.sensors, self.drive))
            if self.drive.control_period_s is not None or self.control_period_s == LONGEST_CONTROL_PERIOD_S:
                changes.setdefault("control_period_s", _LEFT_OUT)
        period = changes.get("control_period_s", self.control_period_s) or LONGEST_CONTROL_PERIOD_S
        if isinstance(drive, DriveDocument):
            period = drive.control_period_s or period
        if period != self.control_period_s:
            changes.setdefault("duration_s", on_whole_periods(self.duration_s, period))
        return super().replaced(**changes)

    @property
    def supply_profile(self) -> Profile:
        """Voltage of each half of the supply over time (s, V), the drive's where none is given."""
        return COURSES["supply"].profile(self)

    @property
    def load_profile(self) -> Profile:
        """Share of the load over time (s, -), 1 throughout for a locked shaft; a vehicle's grade (s, %)."""
        return COURSES["load"].profile(self)

    @property
    def torque_reference_profile(self) -> Profile:
        """Torque reference over time (s, N·m), 0 throughout where the reference is a speed."""
        return COURSES["torque_reference"].profile(self)

    def nameplate(self) -> Nameplate:
        nameplate = self.drive.nameplate(self.control_period_s)
        if isinstance(self.load, VehicleLoad):
            return nameplate._replace(inertia=nameplate.inertia + self.load.inertia_kg_m2)
        return nameplate

    @property
    def control_periods(self) -> int:
        return round(self.duration_s / self.control_period_s)


def scenario_schema() -> dict[str, Any]:
    """Make the JSON Schema of the document; its drive may be a name, a path or a table."""
    schema = Scenario.model_json_schema(by_alias=True)
    schema["properties"]["schema"] = {"const": 2, "description": "number of the document's schema"}
    schema["required"] = ["schema", *(key for key in schema["required"] if key not in FOLLOWING_KEYS)]
    drive, sensors = (schema["properties"][key] for key in ("drive", "sensors"))
    schema["properties"]["drive"] = {"type": ["string", "object"], "description": drive["description"]}
    schema["properties"]["sensors"] = {
        "anyOf": [{"type": "string", "enum": sorted(PLAIN)}, {"oneOf": sensors["oneOf"]}],
        "description": sensors["description"],
    }
    # A drive has a schema of its own.
    parts, used = schema["$defs"], json.dumps(schema["properties"])
    while (seen := {name: part for name, part in parts.items() if f'#/$defs/{name}"' in used}) != schema[
        "$defs"
    ]:
        schema["$defs"] = seen
        used = json.dumps([schema["properties"], seen])
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "drivegate scenario, schema 2",
        **{key: value for key, value in schema.items() if key != "title"},
    }


def load_scenario(name_or_path: str | Path) -> Scenario:
    """Load a scenario that comes with drivegate, or one from a file."""
    return load_named(name_or_path, Scenario, "scenarios", "scenario")


def scenario_names() -> tuple[str, ...]:
    return packaged_names("scenarios")
