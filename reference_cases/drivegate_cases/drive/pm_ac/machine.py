"""The table `[machine]` of a PM AC drive: its windings in the rotor's frame, and the shaft."""

from typing import Annotated

from pydantic import Field

from drivegate_cases.documents.document import Section

PHASES = 3

_Torque = Annotated[float, Field(ge=0.0, le=1e5)]
_Inductance = Annotated[float, Field(gt=0.0, le=1e2)]


class PmAcMachine(Section):
    """A star of three sinusoidal phases with an isolated neutral; quantities of the rotor's frame are peak values."""

    pole_pairs: int = Field(ge=1, le=200, description="electrical cycles in a turn of the shaft")
    resistance_ohm: float = Field(ge=0.0, le=1e4, description="resistance of one phase, in ohm")
    direct_inductance_h: _Inductance = Field(description="inductance along the magnet's axis, L_d, in henry")
    quadrature_inductance_h: _Inductance = Field(description="inductance across it, L_q, in henry")
    magnet_flux_v_s: float = Field(
        gt=0.0, le=1e3, description="peak flux linkage of one phase by the magnet, in volt seconds"
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

    @property
    def phases(self) -> int:
        """Number of phases."""
        return PHASES
