"""Types of the values in the table `[machine]` that machines of every kind have."""

from typing import Annotated

from pydantic import Field

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
