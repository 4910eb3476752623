"""The motor and its drive as data, and what the plant and a controller know of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from drivegate_cases.documents.document import Document, parse_document
from drivegate_cases.documents.overrides import parse_overrides
from drivegate_cases.documents.packaged import load_named, packaged_names
from drivegate_cases.motor.emf_table import EmfTable, check_emf_table
from drivegate_cases.motor.scales import NOMINAL, Scales

if TYPE_CHECKING:
    from drivegate_models.contract.outer_loop.signals import Nameplate
    from drivegate_models.half_bridge.plant.drive import Drive

HIGHEST_CHOPPING_FREQUENCY_HZ = 10e6
RPM = 2.0 * math.pi / 60.0

_Torque = Annotated[float, Field(ge=0.0, le=1e5)]
_Energy = Annotated[float, Field(ge=0.0, le=1e3)]


class Motor(Document):
    """A motor with its split supply, inverter and current controllers; phases are alike and decoupled."""

    name: str = Field(min_length=1, max_length=200, description="name of the motor")
    phases: int = Field(ge=1, le=31, description="number of phases, half a cycle divided by it apart")
    pole_pairs: int = Field(ge=1, le=200, description="electrical cycles in a turn of the shaft")
    resistance_ohm: float = Field(ge=0.0, le=1e4, description="resistance of one phase, in ohm")
    inductance_h: float = Field(gt=0.0, le=1e2, description="inductance of one phase, in henry")
    emf_constant_v_s_per_rad: float = Field(
        gt=0.0, le=1e4, description="peak EMF of one phase over the shaft's speed, in volt seconds per radian"
    )
    emf_shape: Literal["trapezoid", "sine", "table"] = Field(description="shape of the EMF over the angle")
    emf_flat_deg: float | None = Field(
        default=None, ge=0.0, lt=180.0, description="flat width of a trapezoidal EMF, in electrical degrees"
    )
    emf_table: EmfTable = Field(
        default=(),
        description="list of [electrical degrees, share of the peak] over 0 to 180, of a table's EMF",
    )
    core_loss_conductance_s: float = Field(
        default=0.0,
        ge=0.0,
        le=1e2,
        description="conductance that stands for the core loss of a phase, in siemens",
    )
    inertia_kg_m2: float = Field(
        gt=0.0, le=1e6, description="inertia of the shaft, in kilogram square metres"
    )
    friction_n_m: _Torque = Field(default=0.0, description="friction torque at any speed, in newton metres")
    viscous_friction_n_m_s_per_rad: _Torque = Field(
        default=0.0, description="friction torque over speed, in newton metre seconds per radian"
    )
    supply_voltage_v: float = Field(gt=0.0, le=1e5, description="voltage of one half of the supply, in volts")
    hysteresis_band_a: float = Field(
        ge=0.0, le=1e4, description="half-width of the current band, in ampere, or 0 for the ideal regulator"
    )
    window_deg: float = Field(
        gt=0.0, le=180.0, description="conduction in each half cycle, in electrical degrees"
    )
    current_limit_a: float = Field(gt=0.0, le=1e5, description="greatest current reference, in ampere")
    base_speed_rpm: float = Field(gt=0.0, le=1e6, description="base speed of the shaft, in turns a minute")
    rated_power_w: float = Field(gt=0.0, le=1e9, description="rated power at the shaft, in watts")
    switch_drop_v: float = Field(default=0.0, ge=0.0, description="forward drop of a switch, in volts")
    diode_drop_v: float = Field(default=0.0, ge=0.0, description="forward drop of a diode, in volts")
    turn_on_energy_j: _Energy = Field(
        default=0.0, description="energy lost each time a switch closes, in joules"
    )
    turn_off_energy_j: _Energy = Field(
        default=0.0, description="energy lost each time a switch opens, in joules"
    )
    provenance: dict[str, str] = Field(
        default_factory=dict, description="table that says where the values come from, one sentence a key"
    )

    @field_validator("emf_table")
    @classmethod
    def _table_is_a_shape(cls, table: EmfTable) -> EmfTable:
        return check_emf_table(table)

    @field_validator("hysteresis_band_a")
    @classmethod
    def _band_is_resolvable(cls, band: float) -> float:
        if 0.0 < band < 0.001:
            raise ValueError("must be 0 for the ideal regulator, or at least 0.001")
        return band

    @field_validator("provenance")
    @classmethod
    def _provenance_is_of_keys(cls, provenance: dict[str, str]) -> dict[str, str]:
        unknown = sorted(set(provenance) - set(cls.model_fields))
        if unknown:
            raise ValueError(f"'{unknown[0]}' is no key of a motor")
        return provenance

    @model_validator(mode="after")
    def _keys_fit_together(self) -> Self:
        if self.emf_shape == "trapezoid" and self.emf_flat_deg is None:
            raise ValueError(
                "the key 'emf_flat_deg' is missing, but must be given for the shape \"trapezoid\""
            )
        if self.emf_shape == "table" and not self.emf_table:
            raise ValueError("the key 'emf_table' is missing, but must be given for the shape \"table\"")
        for key in ("switch_drop_v", "diode_drop_v"):
            if getattr(self, key) >= self.supply_voltage_v:
                raise ValueError(
                    f"the key '{key}' is {getattr(self, key)}, "
                    f"but must be below the supply's {self.supply_voltage_v} V"
                )
        self._check_chopping()
        return self

    def _check_chopping(self) -> None:
        """Refuse a band that the current crosses faster than any device could follow.

        With no EMF the current moves by V/L a second, so it crosses the half-width h up and down V/(2 L h)
        times a second; the plant solves each crossing, and its work grows with them.
        """
        if self.hysteresis_band_a == 0.0:
            return
        narrowest = self.supply_voltage_v / (2.0 * self.inductance_h * HIGHEST_CHOPPING_FREQUENCY_HZ)
        if self.hysteresis_band_a < narrowest:
            raise ValueError(
                f"the key 'hysteresis_band_a' is {self.hysteresis_band_a}, but with this supply and "
                f"inductance_h must be at least {narrowest:.3g}, so that it chops at no more than 10 MHz"
            )

    def __hash__(self) -> int:
        """Hash the values; the provenance, a table, is left out."""
        return hash(tuple(getattr(self, key) for key in type(self).model_fields if key != "provenance"))

    def with_overrides(self, pairs: Sequence[str]) -> Motor:
        """Set single values from the command line."""
        if not pairs:
            return self
        values = parse_overrides(pairs, SETTABLE_KEYS)
        mapping = self.to_mapping()
        sources = mapping["provenance"] | dict.fromkeys(values, "set on the command line")
        return parse_document(
            mapping | values | {"provenance": sources}, Motor, "--set " + " --set ".join(pairs)
        )

    def drive(self, scales: Scales | None = None) -> Drive:
        """Make the plant's parameters, in SI units."""
        from drivegate_models.half_bridge.plant.drive import make_drive
        from drivegate_models.machine.emf import sine_corners, table_corners, trapezoid_corners

        factors = scales or NOMINAL
        if self.emf_shape == "table":
            angles = [math.radians(angle) for angle, _ in self.emf_table]
            corners = table_corners(angles, [value for _, value in self.emf_table])
        elif self.emf_shape == "sine":
            corners = sine_corners()
        else:
            assert self.emf_flat_deg is not None, "a trapezoid without its flat width is refused on entry"
            corners = trapezoid_corners(math.radians(self.emf_flat_deg))
        return make_drive(
            phases=self.phases,
            pole_pairs=self.pole_pairs,
            resistance=self.resistance_ohm * factors.resistance,
            inductance=self.inductance_h * factors.inductance,
            emf_constant=self.emf_constant_v_s_per_rad * factors.emf_constant,
            emf_angles=corners[0],
            emf_values=corners[1],
            half_supply_voltage=self.supply_voltage_v,
            hysteresis_band=self.hysteresis_band_a,
            window=math.radians(self.window_deg),
            current_limit=self.current_limit_a,
            core_loss_conductance=self.core_loss_conductance_s,
            inertia=self.inertia_kg_m2,
            friction=self.friction_n_m + factors.friction_added_n_m,
            viscous_friction=self.viscous_friction_n_m_s_per_rad,
            switch_drop=self.switch_drop_v,
            diode_drop=self.diode_drop_v,
            turn_on_energy=self.turn_on_energy_j,
            turn_off_energy=self.turn_off_energy_j,
        )

    def nameplate(self, control_period: float) -> Nameplate:
        """Make what a controller is given before a run, in SI units."""
        from drivegate_models.contract.outer_loop.signals import Nameplate

        return Nameplate(
            phases=self.phases,
            pole_pairs=self.pole_pairs,
            half_supply_voltage=self.supply_voltage_v,
            base_speed=self.base_speed_rpm * RPM,
            rated_power=self.rated_power_w,
            current_limit=self.current_limit_a,
            control_period=control_period,
            hysteresis_band=self.hysteresis_band_a,
            resistance=self.resistance_ohm,
            inductance=self.inductance_h,
            emf_constant=self.emf_constant_v_s_per_rad,
            inertia=self.inertia_kg_m2,
        )


SETTABLE_KEYS = tuple(key for key in Motor.model_fields if key not in ("schema_version", "provenance"))
"""Keys of a motor that ``--set`` takes."""


def load_motor(name_or_path: str | Path, *, beside: Path | None = None) -> Motor:
    """Load a motor that comes with drivegate, or one from a file."""
    return load_named(name_or_path, Motor, "motors", "motor", beside=beside)


def motor_names() -> tuple[str, ...]:
    """List the motors that come with drivegate."""
    return packaged_names("motors")
