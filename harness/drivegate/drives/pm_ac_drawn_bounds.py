"""The bounds within which PM AC drives are drawn, each with its reason."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from drivegate.drives.drawn_bounds import Bound

FEWEST_PERIODS: Final = 20.0
"""Control periods in an electrical period at the highest speed, at least (1)."""
DOUBLE: Final = 0.5
"""Share of the drives whose duty ratios are updated twice in a period of the carrier."""
_IMPEDANCE: Final = "of the voltage over the current limit"
_VOLTAGE: Final = "of the voltage"
_TORQUE: Final = "of rated torque"

PM_AC_BOUNDS: Final = MappingProxyType(
    {
        "pole_pairs": Bound("pole pairs", "", 1, 12, "from small fast rotors to large slow ones"),
        "apparent_power": Bound(
            "three halves of voltage and current limit",
            "VA",
            100.0,
            50e3,
            "from a pump to the traction of a car; the voltage is what the link gives a phase without distortion",
            by_ratio=True,
        ),
        "link": Bound("link", "V", 24.0, 800.0, "from a battery to a rectifier", by_ratio=True),
        "current": Bound(
            "current limit",
            "A",
            1.0,
            400.0,
            "what one bridge conducts; it narrows the link's range for the power that has been drawn",
        ),
        "base_frequency": Bound(
            "electrical frequency at base speed",
            "Hz",
            25.0,
            150.0,
            "the base speed follows from it and the pole pairs; the packaged drives have 40 to 101",
            by_ratio=True,
        ),
        "speed_range": Bound(
            "highest speed over base speed", "", 1.2, 3.5, "the packaged drives have 1.3 to 3"
        ),
        "overspeed": Bound(
            "overspeed over highest speed", "", 1.02, 1.2, "the packaged drives have 1.03 to 1.15"
        ),
        "emf": Bound("peak EMF at base speed", _VOLTAGE, 0.35, 0.85, "the packaged drives have 0.35 to 0.85"),
        "reactance": Bound(
            "reactance of the magnet's axis at base speed",
            _IMPEDANCE,
            0.25,
            0.9,
            "constant power over speed takes a large one; the packaged drives have 0.3 to 0.86",
        ),
        "saliency": Bound(
            "inductance across the magnet's axis over that along it",
            "",
            1.0,
            3.0,
            "from magnets on the surface to deeply buried ones",
        ),
        "resistance": Bound(
            "resistance", _IMPEDANCE, 0.015, 0.11, "the packaged drives have 0.028 to 0.105", by_ratio=True
        ),
        "power": Bound(
            "rated power",
            "of three halves of voltage and current limit",
            0.3,
            0.7,
            "the packaged drives have 0.32 to 0.67; what the limits do not leave is drawn anew",
        ),
        "control_frequency": Bound(
            "control periods in a second",
            "Hz",
            4e3,
            20e3,
            f"at least {FEWEST_PERIODS:g} in an electrical period at the highest speed; in half of the drives two in "
            "a period of the carrier",
            by_ratio=True,
        ),
        "dead_time": Bound(
            "dead time",
            "of the control period",
            0.0,
            0.016,
            "pm-ac-2kw has 0.016, the other packaged ones none",
        ),
        "mechanical_time": Bound(
            "mechanical time constant J·ω/T at base speed",
            "s",
            0.05,
            0.5,
            "from a bare rotor to one with its load's inertia; the packaged drives have 0.13 to 0.24",
            by_ratio=True,
        ),
        "core_loss": Bound(
            "core-loss conductance",
            "of the current limit over the voltage",
            0.0,
            0.04,
            "pm-ac-interior has 0.03",
        ),
        "friction": Bound("friction", _TORQUE, 0.0, 0.02, "bearings and seals"),
        "viscous_friction": Bound(
            "viscous friction at base speed", _TORQUE, 0.0, 0.02, "bearings and windage"
        ),
    }
)
"""The bounds, by what `drivegate.drives.pm_ac_drawn_drives` knows them as."""
