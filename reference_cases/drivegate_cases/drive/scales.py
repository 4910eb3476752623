"""How a plant differs from the nominal drive that its controller knows."""

from typing import Final

from pydantic import Field

from drivegate_cases.documents.document import Section


class Scales(Section):
    """Factors on nominal parameters of a drive; a controller's nameplate keeps the nominal values."""

    resistance: float = Field(default=1.0, ge=0.0, le=100.0, description="factor on the phase resistance")
    inductance: float = Field(default=1.0, ge=0.01, le=100.0, description="factor on the phase inductance")
    emf_constant: float = Field(default=1.0, ge=0.01, le=100.0, description="factor on the EMF constant")
    inertia: float = Field(default=1.0, ge=0.01, le=1000.0, description="factor on the inertia of the drive")
    friction_added_n_m: float = Field(
        default=0.0, ge=0.0, le=1e5, description="friction torque added to the drive's own, in newton metres"
    )


FACTOR_SYMBOLS: Final = {"resistance": "R", "inductance": "L", "emf_constant": "ke", "inertia": "J"}
"""What people call the keys that are factors."""
NOMINAL = Scales()
