"""The table `[link]` of a PM AC drive: the capacitor and the source of its dc link, and a brake chopper."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt
from typing import TYPE_CHECKING, Any, Final, Literal, Self

from pydantic import Field, field_validator, model_validator

from drivegate_cases.documents.document import Section

if TYPE_CHECKING:
    from drivegate_models.pm_ac.plant.dc_link import DcLink

Source = Literal["ideal", "battery", "rectifier"]
USUAL_LIMIT: Final = 1.2
"""Greatest permitted voltage of the link over its nominal one, for a drive that does not state it (1)."""
FASTEST: Final = 20.0
"""Greatest rate of the link's own voltage times the control period, which still is followed exactly (1)."""
USUAL_DISCHARGE: Final = 1.5
"""Greatest mean current of the source over that of rated power, for a drive that does not state it (1)."""
_IN_HAND: Final = 2.0
"""Least power that the source can supply at all, over rated power (1)."""
_MOST_FARADS: Final = 10.0
_LEAST_HYSTERESIS: Final = 0.001


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

    @model_validator(mode="before")
    @classmethod
    def _source_has_no_inductance(cls, values: Any) -> Any:
        if isinstance(values, Mapping) and "source_inductance_h" in values:
            raise ValueError(
                "the key 'source_inductance_h' is unknown: the source has a resistance alone, so leave its inductance "
                "out"
            )
        return values

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
        nominal = inverter.link_voltage_v
        if self.source == "ideal":
            return
        if self.source_voltage_v is not None and self.source_voltage_v != nominal:
            raise ValueError(
                f"the key 'source_voltage_v' in [link] is {self.source_voltage_v:g}, but must be the link_voltage_v of "
                f"[inverter], {nominal:g} V; state the voltage of the source there"
            )
        self._check_voltages(nominal)
        capacitance, resistance = self.capacitance_f, self.source_resistance_ohm
        assert capacitance is not None
        assert resistance is not None
        period = inverter.control_period_s
        own = 1.0 / (resistance * capacitance)
        if own * period > FASTEST:
            raise ValueError(
                f"the link charges from its source in {1.0 / own:.3g} s, less than a twentieth of the control period "
                f"of {period:.3g} s; state a greater capacitance_f or source_resistance_ohm in [link], or leave [link] "
                "out for an ideal source"
            )
        least = min(machine.direct_inductance_h, machine.quadrature_inductance_h)
        if sqrt(1.5 / (least * capacitance)) * period > FASTEST:
            raise ValueError(
                f"the key 'capacitance_f' in [link] is {capacitance:g}, with which the link oscillates with the "
                f"machine more than three times in a control period of {period:.3g} s; is it in farads?"
            )
        most = nominal * nominal / (4.0 * resistance)
        if most < _IN_HAND * rating.rated_power_w:
            raise ValueError(
                f"the key 'source_resistance_ohm' in [link] is {resistance:g}, with which {nominal:g} V supply at most "
                f"{most:.3g} W; a rated power of {rating.rated_power_w:g} W requires at most "
                f"{nominal * nominal / (4.0 * _IN_HAND * rating.rated_power_w):.3g} ohm"
            )

    def _check_voltages(self, nominal: float) -> None:
        """Refuse a limit or thresholds below the nominal voltage (V), or in the wrong order."""
        limit = self.limit(nominal)
        if limit <= nominal:
            raise ValueError(
                f"the key 'link_limit_v' in [link] is {limit:g}, but must be above the nominal {nominal:g} V"
            )
        on, off = self.chopper_on_v, self.chopper_off_v
        if on is None or off is None:
            return
        if off <= nominal:
            raise ValueError(
                f"the key 'chopper_off_v' in [link] is {off:g}, but must be above the nominal {nominal:g} V, or the "
                "chopper burns what the source supplies"
            )
        if on < off + _LEAST_HYSTERESIS * nominal:
            raise ValueError(
                f"the key 'chopper_on_v' in [link] is {on:g}, but must be above chopper_off_v, {off:g}, by at least "
                f"0.1 % of the nominal {nominal:g} V"
            )
        if on >= limit:
            raise ValueError(
                f"the key 'chopper_on_v' in [link] is {on:g}, but must be below the link's limit of {limit:g} V"
            )

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
        )
