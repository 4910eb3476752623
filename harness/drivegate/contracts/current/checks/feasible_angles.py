"""In plain words, which advance angles count as feasible: those that give the torque at the current limit too."""

from __future__ import annotations

from typing import Final

FEASIBLE: Final = (
    "An angle is feasible where it gives the torque with the current reference at its limit too. At another one a "
    "smaller reference may give it, even with Σ|i| below the least of the feasible angles, but a regulator at its "
    "limit may lose it."
)
"""What feasible means, and why Σ|i| may lie below the least."""


def given_below_limit(reference: float) -> str:
    """State what is lost where a current reference gives a torque, and the limit does not (A)."""
    return f"{reference:.3g} A gives the torque, but a regulator at its limit may lose it"
