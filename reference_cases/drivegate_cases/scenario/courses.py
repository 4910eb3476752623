"""Every quantity that a scenario states over time, declared once: its keys, its nominal value, what it means.

A new key of this kind is a field of a table of the scenario, such as `Drift`, and a row of `COURSES`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any, Final, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from drivegate_cases.documents.document import Section
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.plant import FACTOR_SYMBOLS, Scales
from drivegate_cases.drive.rating import GREATEST_TORQUE_NM, OVER_RATING
from drivegate_cases.scenario.piecewise import Profile, values_within
from drivegate_models.units import RADIANS_PER_RPM

_Factors = Annotated[Profile, values_within(0.1, 10.0, "must have factors from 0.1 to 10")]
_MOST_FRICTION_NM = OVER_RATING * GREATEST_TORQUE_NM
_AddedFriction = Annotated[
    Profile, values_within(0.0, _MOST_FRICTION_NM, f"must have torques from 0 to {_MOST_FRICTION_NM:g} N·m")
]
_PERCENT = 0.01


class Drift(Section):
    """How the plant's parameters change during a run.

    Windings and magnets change with temperature, the inertia where a wheel is lifted from the ground or set down, and
    the friction where a brake drags.
    """

    resistance: _Factors | None = Field(default=None, description="factor on the phase resistance over time")
    emf_constant: _Factors | None = Field(default=None, description="factor on the EMF constant over time")
    inertia: _Factors | None = Field(
        default=None, description="factor on the inertia of rotor and load over time"
    )
    friction_n_m: _AddedFriction | None = Field(
        default=None,
        description="friction torque added to the drive's own over time, in newton metres",
    )

    @model_validator(mode="after")
    def _has_one(self) -> Self:
        if all(profile is None for _, profile in self):
            *others, last = (f"'{key}'" for key in type(self).model_fields)
            raise ValueError(f"must give {', '.join(others)} or {last}")
        return self


Content: TypeAlias = Section | Mapping[str, Any]
"""A scenario, or one as plain data."""
Role: TypeAlias = Literal["demand", "supply", "fault"]
"""What a quantity is in a run: what is demanded of the drive, what feeds it, or what is wrong with it."""


@dataclass(frozen=True)
class Quantity:
    """A quantity with a course over time."""

    name: str
    """Its name among the conditions of the plant."""
    role: Role
    keys: Mapping[str, float]
    """The keys that can state it, each with its unit over the one of the plant (1)."""
    nominal: float | None
    """Its value where no key states it, in the unit of the key; None: half of the drive's supply (V)."""
    scale: str | None = None
    """The key of `scales` that it changes, of a parameter of the plant."""
    symbol: str = ""
    verb: str = ""
    unit: str = "times"
    """How people call the parameter, its change and its unit."""

    @property
    def is_factor(self) -> bool:
        """Whether it multiplies its parameter; any other is added to it."""
        return self.nominal == 1.0

    def key(self, scenario: Content) -> str | None:
        """Return the key that states it in a scenario, or in one as plain data; None where none does."""
        return next((key for key in self.keys if _stated(scenario, key) is not None), None)

    def stated(self, scenario: Content) -> Profile | None:
        """Return its course over time (s, in the unit of the key) in a scenario that states it."""
        return next((profile for key in self.keys if (profile := _stated(scenario, key)) is not None), None)

    def profile(self, scenario: Section) -> Profile:
        """Return its course over time, the nominal value where it is not stated."""
        return self.stated(scenario) or ((0.0, self.nominal_in(_entry(scenario, "drive"))),)

    def nominal_in(self, drive: DriveDocument) -> float:
        """Return its value where no key states it."""
        return drive.inverter.supply_voltage_v if self.nominal is None else self.nominal

    def fields(self, scenario: Section, profile: Profile) -> dict[str, Any]:
        """Return the fields of a scenario in which it takes another course; none where no key could state that."""
        # A load has keys of its own kind alone; any scenario can have the others.
        free_key = next((key for key in self.keys if not key.startswith("load.")), None)
        if (key := self.key(scenario) or free_key) is None:
            return {}
        if self.name == "speed":
            return {"speed_rpm": profile, "initial_speed_rpm": profile[0][1]}
        is_plain = self.role != "demand" and profile == ((0.0, self.nominal_in(_entry(scenario, "drive"))),)
        value = None if is_plain else profile
        table, _, name = key.rpartition(".")
        if not table:
            return {name: value}
        changed = (getattr(scenario, table) or Drift.model_construct()).model_copy(update={name: value})
        return {table: changed if any(dict(changed).values()) else None}


def _stated(scenario: Content, key: str) -> Any:
    table, _, name = key.rpartition(".")
    section = _entry(scenario, table) if table else scenario
    return None if section is None else _entry(section, name)


def _entry(section: Any, name: str) -> Any:
    return getattr(section, name, None) if isinstance(section, Section) else section.get(name)


def _drifting(key: str, scale: str, verb: str = "drifts") -> Quantity:
    """Make the row of a factor on a parameter of the plant."""
    return Quantity(key, "fault", {f"drift.{key}": 1.0}, 1.0, scale, FACTOR_SYMBOLS[scale], verb)


COURSES: Final[Mapping[str, Quantity]] = MappingProxyType(
    {
        quantity.name: quantity
        for quantity in (
            Quantity("speed", "demand", {"speed_rpm": RADIANS_PER_RPM}, 0.0),
            Quantity("supply", "supply", {"supply_v": 1.0}, None),
            Quantity("load", "demand", {"load.factor": 1.0, "load.grade_percent": _PERCENT}, 1.0),
            Quantity("torque_reference", "demand", {"load.torque_reference_nm": 1.0}, 0.0),
            Quantity("imbalance", "fault", {"imbalance": 1.0}, 0.0),
            _drifting("resistance", "resistance"),
            _drifting("emf_constant", "emf_constant"),
            _drifting("inertia", "inertia", "changes"),
            Quantity(
                "friction",
                "fault",
                {"drift.friction_n_m": 1.0},
                0.0,
                "friction_added_n_m",
                symbol="friction",
                verb="changes",
                unit="N·m",
            ),
        )
    }
)
"""All of them by name, in the order in which a scenario is checked and described."""
PARAMETERS: Final = tuple(quantity for quantity in COURSES.values() if quantity.scale is not None)
"""Those that change a parameter of the plant."""
DISTURBANCES: Final = tuple(quantity for quantity in COURSES.values() if quantity.role != "demand")
"""Those that have a nominal value."""


def profiles_of(scenario: Section) -> dict[str, Profile]:
    """Return the course of every quantity."""
    return {name: quantity.profile(scenario) for name, quantity in COURSES.items()}


def stated_profiles(scenario: Content) -> Iterator[tuple[str, Profile]]:
    """List the courses that a scenario, also as plain data, states, each with its key."""
    for quantity in COURSES.values():
        if (key := quantity.key(scenario)) is not None:
            yield key, _stated(scenario, key)


def with_courses(scales: Scales, values: Mapping[str, float]) -> Scales:
    """Return the plant's parameters where the quantities, by name, have some values."""
    changed = {
        str(quantity.scale): _combined(quantity, scales, values[quantity.name])
        for quantity in PARAMETERS
        if values.get(quantity.name, quantity.nominal) != quantity.nominal
    }
    return scales.model_copy(update=changed) if changed else scales


def friction_since(begin: Scales, scales: Scales) -> float:
    """Return the friction that a run has added to that of its beginning, which acts like a load (N·m)."""
    return scales.friction_added_n_m - begin.friction_added_n_m


def _combined(quantity: Quantity, scales: Scales, value: float) -> float:
    own: float = getattr(scales, str(quantity.scale))
    return own * value if quantity.is_factor else own + value
