"""The plant of a drive: its tables `[machine]` and `[inverter]`, factors on their values, and its constants."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self

from pydantic import AfterValidator, Field, field_validator, model_validator

from drivegate_cases.documents.document import Section
from drivegate_cases.drive.rating import GREATEST_TORQUE_NM, OVER_RATING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from drivegate_models.steady.plant import AnyDrive

PolePairs = Annotated[int, Field(ge=1, le=200, description="electrical cycles in a turn of the shaft")]
Resistance = Annotated[float, Field(ge=0.0, le=1e6, description="resistance of one phase, in ohm")]
CoreLossConductance = Annotated[
    float,
    Field(ge=0.0, le=1e6, description="conductance that stands for the core loss of a phase, in siemens"),
]
Inertia = Annotated[
    float, Field(gt=0.0, le=1e11, description="inertia of the shaft, in kilogram square metres")
]
Friction = Annotated[
    float, Field(ge=0.0, le=GREATEST_TORQUE_NM, description="friction torque at any speed, in newton metres")
]
ViscousFriction = Annotated[
    float,
    Field(ge=0.0, le=1e11, description="friction torque over speed, in newton metre seconds per radian"),
]

OF_SHAPE: Final[Mapping[str, tuple[str, Any]]] = {
    "emf_flat_deg": ("trapezoid", None),
    "emf_table": ("table", ()),
}
"""Keys of one shape of the EMF alone: the shape, and the key's value for any other."""


EmfPoint = Annotated[tuple[float, float], Field(description="electrical degrees, share of the peak")]
EmfTable = tuple[EmfPoint, ...]

_PEAK_TOLERANCE = 1e-9
_LEAST_STEP_DEG = 1e-6
_Energy = Annotated[float, Field(ge=0.0, le=1e3)]


def check_emf_table(table: EmfTable) -> EmfTable:
    """Check that a table describes half a cycle of an odd, half-wave symmetric shape of peak 1."""
    if not table:
        return table
    angles = [angle for angle, _ in table]
    values = [value for _, value in table]
    if angles[0] != 0.0 or angles[-1] != 180.0:
        raise ValueError("must begin at 0 and end at 180 electrical degrees")
    if any(later - earlier < _LEAST_STEP_DEG for earlier, later in pairwise(angles)):
        raise ValueError(f"must have strictly increasing angles, at least {_LEAST_STEP_DEG:g} degrees apart")
    if values[0] != 0.0 or values[-1] != 0.0:
        raise ValueError("must have the value 0 at 0 and at 180 electrical degrees")
    if abs(max(values) - 1.0) > _PEAK_TOLERANCE or min(values) < -1.0 - _PEAK_TOLERANCE:
        raise ValueError("must have the value 1 as its greatest, and none below -1")
    return table


class Machine(Section):
    """A machine whose phases are alike: decoupled, or star-connected with an isolated neutral."""

    phases: int = Field(
        ge=1,
        le=31,
        description="number of phases; neighbours are half a cycle over it apart, in a star a whole one",
    )
    pole_pairs: PolePairs
    resistance_ohm: Resistance
    inductance_h: float = Field(
        gt=0.0, le=1e6, description="inductance of one phase, in a star less the mutual one, in henry"
    )
    emf_constant_v_s_per_rad: float = Field(
        gt=0.0, le=1e6, description="peak EMF of one phase over the shaft's speed, in volt seconds per radian"
    )
    emf_shape: Literal["trapezoid", "sine", "table"] = Field(description="shape of the EMF over the angle")
    emf_flat_deg: float | None = Field(
        default=None, ge=0.0, lt=180.0, description="flat width of a trapezoidal EMF, in electrical degrees"
    )
    emf_table: Annotated[EmfTable, AfterValidator(check_emf_table)] = Field(
        default=(),
        description="list of [electrical degrees, share of the peak] over 0 to 180, of a table's EMF",
    )
    core_loss_conductance_s: CoreLossConductance = 0.0
    inertia_kg_m2: Inertia
    friction_n_m: Friction = 0.0
    viscous_friction_n_m_s_per_rad: ViscousFriction = 0.0

    @model_validator(mode="after")
    def _shape_has_its_values(self) -> Self:
        if self.emf_shape == "trapezoid" and self.emf_flat_deg is None:
            raise ValueError(
                "the key 'emf_flat_deg' is missing, but must be given for the shape \"trapezoid\""
            )
        if self.emf_shape == "table" and not self.emf_table:
            raise ValueError("the key 'emf_table' is missing, but must be given for the shape \"table\"")
        for key, (shape, absent) in OF_SHAPE.items():
            if self.emf_shape != shape and getattr(self, key) != absent:
                raise ValueError(
                    f"the key '{key}' is for the shape \"{shape}\", but the key 'emf_shape' is \"{self.emf_shape}\""
                )
        return self


class Inverter(Section):
    """Half-bridge legs, each with a hysteresis current regulator, at a split supply or a link of twice its voltage."""

    supply_voltage_v: float = Field(
        gt=0.0,
        le=1e5,
        description="voltage of one half of the supply, in volts; of a star, half of its link's",
    )
    hysteresis_band_a: float = Field(
        ge=0.0, le=1e4, description="half-width of the current band, in ampere, or 0 for the ideal regulator"
    )
    window_deg: float = Field(
        gt=0.0, le=180.0, description="conduction in each half cycle, in electrical degrees"
    )
    regulation: Literal["every-half", "upper-only", "pwm-on", "on-pwm"] | None = Field(
        default=None,
        description="parts of a star's windows that chop: every half, those of the upper switches only, the first "
        "halves, or the second; every half where it is left out",
    )
    switch_drop_v: float = Field(default=0.0, ge=0.0, description="forward drop of a switch, in volts")
    diode_drop_v: float = Field(default=0.0, ge=0.0, description="forward drop of a diode, in volts")
    turn_on_energy_j: _Energy = Field(
        default=0.0, description="energy lost each time a switch closes, in joules"
    )
    turn_off_energy_j: _Energy = Field(
        default=0.0, description="energy lost each time a switch opens, in joules"
    )

    @field_validator("hysteresis_band_a")
    @classmethod
    def _band_is_resolvable(cls, band: float) -> float:
        if 0.0 < band < 0.001:
            raise ValueError("must be 0 for the ideal regulator, or at least 0.001")
        return band

    @model_validator(mode="after")
    def _drops_leave_a_voltage(self) -> Self:
        for key in ("switch_drop_v", "diode_drop_v"):
            if getattr(self, key) >= self.supply_voltage_v:
                raise ValueError(
                    f"the key '{key}' is {getattr(self, key)}, "
                    f"but must be below the supply's {self.supply_voltage_v} V"
                )
        return self


class Scales(Section):
    """Factors on nominal parameters of a drive; a controller's nameplate keeps the nominal values."""

    resistance: float = Field(default=1.0, ge=0.0, le=100.0, description="factor on the phase resistance")
    inductance: float = Field(default=1.0, ge=0.01, le=100.0, description="factor on the phase inductance")
    emf_constant: float = Field(default=1.0, ge=0.01, le=100.0, description="factor on the EMF constant")
    inertia: float = Field(default=1.0, ge=0.01, le=1000.0, description="factor on the inertia of the drive")
    friction_added_n_m: float = Field(
        default=0.0,
        ge=0.0,
        le=OVER_RATING * GREATEST_TORQUE_NM,
        description="friction torque added to the drive's own, in newton metres",
    )


FACTOR_SYMBOLS: Final = {"resistance": "R", "inductance": "L", "emf_constant": "ke", "inertia": "J"}
"""What people call the keys that are factors."""
NOMINAL = Scales()


def plant_constants(
    kind: str, machine: Machine, inverter: Inverter, current_limit_a: float, scales: Scales
) -> AnyDrive:
    """Return the constants of a plant in SI units that differs from its drive by `scales`.

    They are of the type of the drive's kind, by which compiled functions find the plant.
    """
    angles, values = _emf_corners(machine)
    return _MAKE[kind](
        inverter,
        phases=machine.phases,
        pole_pairs=machine.pole_pairs,
        resistance=machine.resistance_ohm * scales.resistance,
        inductance=machine.inductance_h * scales.inductance,
        emf_constant=machine.emf_constant_v_s_per_rad * scales.emf_constant,
        emf_angles=angles,
        emf_values=values,
        half_supply_voltage=inverter.supply_voltage_v,
        hysteresis_band=inverter.hysteresis_band_a,
        window=math.radians(inverter.window_deg),
        current_limit=current_limit_a,
        core_loss_conductance=machine.core_loss_conductance_s,
        inertia=machine.inertia_kg_m2 * scales.inertia,
        friction=machine.friction_n_m + scales.friction_added_n_m,
        viscous_friction=machine.viscous_friction_n_m_s_per_rad,
        switch_drop=inverter.switch_drop_v,
        diode_drop=inverter.diode_drop_v,
        turn_on_energy=inverter.turn_on_energy_j,
        turn_off_energy=inverter.turn_off_energy_j,
    )


def _emf_corners(machine: Machine) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    # It brings numpy, which a document that is refused does not need.
    from drivegate_models.machine.emf import sine_corners, table_corners, trapezoid_corners

    if machine.emf_shape == "table":
        angles = [math.radians(angle) for angle, _ in machine.emf_table]
        return table_corners(angles, [value for _, value in machine.emf_table])
    if machine.emf_shape == "sine":
        return sine_corners()
    assert machine.emf_flat_deg is not None, "a trapezoid without its flat width is refused on entry"
    return trapezoid_corners(math.radians(machine.emf_flat_deg))


def _half_bridge(_inverter: Inverter, **constants: Any) -> AnyDrive:
    from drivegate_models.half_bridge.plant.drive import make_drive

    return make_drive(**constants)


def _star(inverter: Inverter, **constants: Any) -> AnyDrive:
    from drivegate_models.star.plant.drive import REGULATIONS, make_star_drive

    return make_star_drive(regulation=REGULATIONS[inverter.regulation or "every-half"], **constants)


_MAKE: Final[Mapping[str, Callable[..., AnyDrive]]] = {"half-bridge": _half_bridge, "star": _star}
