"""The table `[link]` of a PM AC drive: the capacitor and the source of its dc link, and a brake chopper."""

from __future__ import annotations

from math import ceil, pi, prod, sqrt
from typing import TYPE_CHECKING, Any, Final, Literal, Self

from pydantic import Field, field_validator, model_validator

from drivegate_cases.documents.document import Section
from drivegate_cases.drive.pm_ac.link_fit import check_link

if TYPE_CHECKING:
    from drivegate_models.pm_ac.plant.dc_link import DcLink

Source = Literal["ideal", "battery", "rectifier"]
USUAL_LIMIT: Final = 1.2
"""Greatest permitted voltage of the link over its nominal one, for a drive that does not state it (1)."""
USUAL_DISCHARGE: Final = 1.5
"""Greatest mean current of the source over that of rated power, for a drive that does not state it (1)."""
_WELL_DAMPED: Final = 0.99
"""Damping from which on a step of the source exceeds it by less than 3e-10 of the step (1)."""
_MOST_FARADS: Final = 10.0
_MOST_HENRIES: Final = 1.0


class PmAcLink(Section):
    """A capacitor between bridge and source; an ideal source has neither capacitor nor resistance."""

    source: Source = Field(
        default="ideal",
        description='"ideal": constant voltage; "battery": takes current back; "rectifier": takes none back, as a '
        "bench supply",
    )
    source_voltage_v: float | None = Field(
        default=None,
        gt=0.0,
        le=1e5,
        description="voltage of the source without a current, in volts, if stated that of link_voltage_v",
    )
    capacitance_f: float | None = Field(
        default=None, gt=0.0, le=_MOST_FARADS, description="capacitance of the link, in farads"
    )
    source_resistance_ohm: float | None = Field(
        default=None, gt=0.0, le=1e6, description="resistance between source and capacitor, in ohms"
    )
    source_inductance_h: float | None = Field(
        default=None,
        gt=0.0,
        le=_MOST_HENRIES,
        description="inductance between source and capacitor, in henries, by default none",
    )
    charge_limit_a: float | None = Field(
        default=None,
        le=1e6,
        description="greatest mean current that the source takes back, in amperes, at least 0; by default that of "
        "rated power for a battery, 0 for a rectifier",
    )
    discharge_limit_a: float | None = Field(
        default=None,
        gt=0.0,
        le=1e6,
        description="greatest mean current of the source, in amperes, by default 1.5 times that of rated power",
    )
    link_limit_v: float | None = Field(
        default=None,
        gt=0.0,
        le=1e6,
        description="greatest permitted voltage of the link, in volts, by default 1.2 times the nominal one",
    )
    chopper_on_v: float | None = Field(
        default=None, gt=0.0, le=1e6, description="voltage at which the brake chopper turns on, in volts"
    )
    chopper_off_v: float | None = Field(
        default=None, gt=0.0, le=1e6, description="voltage at which it turns off again, in volts"
    )
    chopper_resistance_ohm: float | None = Field(
        default=None, gt=0.0, le=1e6, description="resistance of the brake chopper, in ohms"
    )

    @field_validator("source_inductance_h", mode="before")
    @classmethod
    def _is_in_henries(cls, inductance: Any) -> Any:
        if isinstance(inductance, int | float) and inductance > _MOST_HENRIES:
            raise ValueError(
                f"must be at most {_MOST_HENRIES:g}: in henries, {inductance:g} µH are {1e-6 * inductance:g}"
            )
        return inductance

    @field_validator("capacitance_f", mode="before")
    @classmethod
    def _is_in_farads(cls, capacitance: Any) -> Any:
        if isinstance(capacitance, int | float) and capacitance > _MOST_FARADS:
            raise ValueError(
                f"must be at most {_MOST_FARADS:g}: in farads, {capacitance:g} µF are {1e-6 * capacitance:g}"
            )
        return capacitance

    @field_validator("charge_limit_a")
    @classmethod
    def _charge_is_a_magnitude(cls, charge: float | None) -> float | None:
        if charge is not None and charge < 0.0:
            raise ValueError(
                "must be at least 0: it is the size of the current that the source takes back, so write "
                f"{-charge:g}"
            )
        return charge

    @model_validator(mode="after")
    def _keys_belong_to_the_source(self) -> Self:
        stated = [
            name for name in type(self).model_fields if name != "source" and getattr(self, name) is not None
        ]
        if self.source == "ideal":
            if stated:
                raise ValueError(
                    f"the key '{stated[0]}' is for a link with a capacitor; state source = \"battery\" or "
                    '"rectifier" with it, or leave it out'
                )
            return self
        for name in ("capacitance_f", "source_resistance_ohm"):
            if getattr(self, name) is None:
                raise ValueError(f"the key '{name}' is missing, but source = \"{self.source}\" requires it")
        if self.source == "rectifier" and self.charge_limit_a:
            raise ValueError(
                f"the key 'charge_limit_a' is {self.charge_limit_a:g}, but source = \"rectifier\" takes nothing back; "
                'leave it out, or state source = "battery"'
            )
        if self.source == "battery" and self.charge_limit_a == 0.0:
            raise ValueError(
                "the key 'charge_limit_a' is 0, but source = \"battery\" takes current back; state source = "
                '"rectifier" for one that does not'
            )
        chopper = [name for name in stated if name.startswith("chopper_")]
        if 0 < len(chopper) < 3:
            raise ValueError(
                f"the key '{chopper[0]}' is stated, but a chopper requires all of chopper_on_v, chopper_off_v and "
                "chopper_resistance_ohm"
            )
        return self

    def check_fit(self, machine: Any, inverter: Any, rating: Any) -> None:
        """Refuse values that do not fit the machine, the bridge or the rating of the drive."""
        if self.source != "ideal":
            check_link(self, machine, inverter, rating)

    @property
    def overshoot(self) -> float:
        """Return by how much the link exceeds its source after a step of it, over the height of the step (1)."""
        from drivegate_models.pm_ac.decay import decay_of

        inductance, capacitance = self.source_inductance_h, self.capacitance_f
        if inductance is None or capacitance is None or self.source_resistance_ohm is None:
            return 0.0
        damping = 0.5 * self.source_resistance_ohm * sqrt(capacitance / inductance)
        if damping >= _WELL_DAMPED:
            return 0.0
        exponent = pi * damping / sqrt(1.0 - damping * damping)
        # The series is for arguments up to 1.
        parts = ceil(exponent)
        return prod([decay_of(exponent / parts)] * parts)

    def limit(self, nominal: float) -> float:
        """Return the greatest permitted voltage of the link (V) by its nominal one (V)."""
        return USUAL_LIMIT * nominal if self.link_limit_v is None else self.link_limit_v

    def charge(self, rated: float) -> float:
        """Return the greatest mean current that the source takes back (A) by that of rated power (A)."""
        if self.charge_limit_a is not None:
            return self.charge_limit_a
        return rated if self.source == "battery" else 0.0

    def discharge(self, rated: float) -> float:
        """Return the greatest mean current of the source (A) by that of rated power (A)."""
        return USUAL_DISCHARGE * rated if self.discharge_limit_a is None else self.discharge_limit_a

    def plant(self, nominal: float, rated: float) -> DcLink:
        """Return the constants of the plant by the nominal voltage (V) and the current of rated power (A)."""
        from drivegate_models.pm_ac.plant.dc_link import DcLink

        return DcLink(
            float(self.capacitance_f or 0.0),
            float(self.source_resistance_ohm or 0.0),
            1 if self.source == "battery" else 0,
            float(self.limit(nominal)),
            float(self.charge(rated)),
            float(self.discharge(rated)),
            float(self.chopper_on_v or 0.0),
            float(self.chopper_off_v or 0.0),
            1.0 / self.chopper_resistance_ohm if self.chopper_resistance_ohm else 0.0,
            float(self.source_inductance_h or 0.0),
        )
