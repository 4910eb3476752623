"""The bounds within which drives of the half-bridge kind are drawn, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from random import Random
from types import MappingProxyType
from typing import Final

from drivegate_cases.documents.rounding import significant

DIGITS: Final = 3
"""Digits that a drawn value is rounded to, so that its file reads well."""


@dataclass(frozen=True)
class Bound:
    """What one quantity of a drive is drawn within."""

    quantity: str
    """The quantity."""
    unit: str
    """Its unit, or what it is a share of."""
    lowest: float
    highest: float
    """The range."""
    reason: str
    """Why it is that."""
    by_ratio: bool = False
    """Whether equal ratios are equally likely, instead of equal differences."""

    def drawn(self, source: Random) -> float:
        """Draw a value."""
        return self.between(source, self.lowest, self.highest)

    def between(self, source: Random, lowest: float, highest: float) -> float:
        """Draw a value from a part of the range."""
        if self.by_ratio:
            # A decimal's logarithm is the same on every processor, a library's may not be.
            first, last = Decimal(lowest).ln(), Decimal(highest).ln()
            return rounded(float((first + (last - first) * Decimal(source.random())).exp()))
        return rounded(source.uniform(lowest, highest))

    def drawn_whole(self, source: Random) -> int:
        """Draw a whole number."""
        return source.randint(round(self.lowest), round(self.highest))


def rounded(value: float) -> float:
    """Round a drawn value, or what follows from drawn values."""
    return significant(value, DIGITS)


SINES: Final = 0.25
"""Share of the drives that have a sine EMF in place of a trapezoid."""
_IMPEDANCE: Final = "of half the supply over the current limit"
_TORQUE: Final = "of rated torque"

BOUNDS: Final = MappingProxyType(
    {
        "phases": Bound("phases", "", 3, 9, "odd and even: phases on legs of their own need no star point"),
        "pole_pairs": Bound("pole pairs", "", 2, 16, "from small fast rotors to large slow ones"),
        "rated_power": Bound(
            "rated power", "W", 20.0, 50e3, "from a fan to the traction of a car", by_ratio=True
        ),
        "supply": Bound(
            "half of the supply", "V", 12.0, 600.0, "from a battery to a rectifier", by_ratio=True
        ),
        "phase_current": Bound(
            "rated power over half the supply and phases",
            "A",
            0.1,
            60.0,
            "what one leg conducts; it narrows the supply's range for the power that has been drawn",
        ),
        "base_frequency": Bound(
            "electrical frequency at base speed",
            "Hz",
            25.0,
            200.0,
            "the base speed follows from it and the pole pairs: 94 to 6000 rpm",
            by_ratio=True,
        ),
        "speed_range": Bound(
            "highest speed over base speed", "", 2.0, 4.0, "what phase advance is for; the paper has 3"
        ),
        "overspeed": Bound(
            "overspeed over highest speed", "", 1.1, 1.4, "the paper's drive is taken with 1.33"
        ),
        "idle": Bound(
            "phases outside of their window",
            "of the phases",
            0.1,
            0.34,
            "the window is a whole number of 180° over the phases, as the paper's 144° is four of five",
        ),
        "flat": Bound(
            "flat width of a trapezoid",
            "of the window",
            0.5,
            0.9,
            "the paper's drive is taken with 0.68; one drive in four has a sine instead",
        ),
        "emf": Bound(
            "peak EMF at base speed",
            "of half the supply",
            0.25,
            0.5,
            "below, half the supply is never used up; above, the current is hard to drive at base speed",
        ),
        "current_limit": Bound(
            "current limit",
            "of what rated power takes at base speed, with the peak EMF in each window",
            1.1,
            1.6,
            "the window holds the edges of the EMF and of the current too",
        ),
        "resistance": Bound(
            "resistance", _IMPEDANCE, 0.01, 0.08, "efficient machines; the paper's has 0.04", by_ratio=True
        ),
        "reactance": Bound(
            "reactance at base speed",
            _IMPEDANCE,
            0.5,
            1.2,
            "constant power over speed takes a large one; the paper's has 0.9",
        ),
        "band": Bound(
            "half-width of the band",
            "of the current limit",
            0.008,
            0.03,
            "some tens to some hundreds of chops",
        ),
        "mechanical_time": Bound(
            "mechanical time constant J·ω/T at base speed",
            "s",
            0.03,
            0.5,
            "from a bare rotor to one with its load's inertia",
            by_ratio=True,
        ),
        "core_loss": Bound(
            "core-loss conductance",
            "of the current limit over half the supply",
            0.0,
            0.01,
            "the paper's has 0.006",
        ),
        "friction": Bound("friction", _TORQUE, 0.0, 0.02, "bearings and seals"),
        "viscous_friction": Bound(
            "viscous friction at base speed", _TORQUE, 0.0, 0.02, "bearings and windage"
        ),
    }
)
"""The bounds, by what `drivegate.drives.drawn_drives` knows them as."""
