"""A margin: how far a run is from a check's limit, normalised to it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Margin:
    """What one check says of one run.

    Attributes
    ----------
    check : str
        Identifier of the check.
    value : float
        Distance from the limit over the limit: positive or zero when the requirement is met, negative when not.
    measured : str
        The measured quantity in people's units.
    advisory : bool
        Whether the run lies where the check only advises.
    """

    check: str
    value: float
    measured: str
    advisory: bool = False

    @property
    def met(self) -> bool:
        """Whether the requirement is met."""
        return self.value >= 0.0
