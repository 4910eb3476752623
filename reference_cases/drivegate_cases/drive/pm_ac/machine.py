"""The table `[machine]` of a PM AC drive: its windings in the rotor's frame, and the shaft."""

from typing import Annotated

from pydantic import Field

from drivegate_cases.documents.document import Section
from drivegate_cases.drive.machine_values import (
    CoreLossConductance,
    Friction,
    Inertia,
    PolePairs,
    Resistance,
    ViscousFriction,
)

PHASES = 3

_Inductance = Annotated[float, Field(gt=0.0, le=1e2)]


class PmAcMachine(Section):
    """A star of three sinusoidal phases with an isolated neutral; quantities of the rotor's frame are peak values."""

    pole_pairs: PolePairs
    resistance_ohm: Resistance
    direct_inductance_h: _Inductance = Field(description="inductance along the magnet's axis, L_d, in henry")
    quadrature_inductance_h: _Inductance = Field(description="inductance across it, L_q, in henry")
    magnet_flux_v_s: float = Field(
        gt=0.0, le=1e3, description="peak flux linkage of one phase by the magnet, in volt seconds"
    )
    core_loss_conductance_s: CoreLossConductance = 0.0
    inertia_kg_m2: Inertia
    friction_n_m: Friction = 0.0
    viscous_friction_n_m_s_per_rad: ViscousFriction = 0.0

    @property
    def phases(self) -> int:
        """Number of phases."""
        return PHASES

    @property
    def emf_shape(self) -> str:
        """Shape of the EMF, by the name that the machines have which can have others."""
        return "sine"
