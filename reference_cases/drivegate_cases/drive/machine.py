"""The table `[machine]` of a drive: its windings, their back-EMF, and the shaft."""

from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, field_validator, model_validator

from drivegate_cases.documents.document import Section

PolePairs = Annotated[int, Field(ge=1, le=200, description="electrical cycles in a turn of the shaft")]
"""Number of pole pairs."""

Resistance = Annotated[float, Field(ge=0.0, le=1e4, description="resistance of one phase, in ohm")]
"""Resistance of one phase (Ω)."""

CoreLossConductance = Annotated[
    float,
    Field(ge=0.0, le=1e2, description="conductance that stands for the core loss of a phase, in siemens"),
]
"""Conductance that stands for the core loss of a phase (S)."""

Inertia = Annotated[
    float, Field(gt=0.0, le=1e6, description="inertia of the shaft, in kilogram square metres")
]
"""Inertia of the shaft (kg·m²)."""

Friction = Annotated[
    float, Field(ge=0.0, le=1e5, description="friction torque at any speed, in newton metres")
]
"""Friction torque at any speed (N·m)."""

ViscousFriction = Annotated[
    float,
    Field(ge=0.0, le=1e5, description="friction torque over speed, in newton metre seconds per radian"),
]
"""Friction torque over speed (N·m·s/rad)."""


OF_SHAPE: Final[Mapping[str, tuple[str, Any]]] = {
    "emf_flat_deg": ("trapezoid", None),
    "emf_table": ("table", ()),
}
"""Keys of one shape of the EMF alone: the shape, and the key's value for any other."""


EmfPoint = Annotated[tuple[float, float], Field(description="electrical degrees, share of the peak")]
EmfTable = tuple[EmfPoint, ...]

_PEAK_TOLERANCE = 1e-9
_LEAST_STEP_DEG = 1e-6


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
        gt=0.0, le=1e2, description="inductance of one phase, in a star less the mutual one, in henry"
    )
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
    core_loss_conductance_s: CoreLossConductance = 0.0
    inertia_kg_m2: Inertia
    friction_n_m: Friction = 0.0
    viscous_friction_n_m_s_per_rad: ViscousFriction = 0.0

    @field_validator("emf_table")
    @classmethod
    def _table_is_a_shape(cls, table: EmfTable) -> EmfTable:
        return check_emf_table(table)

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
