"""Rates of the reference controller's speed regulator; scenarios are sized for a regulator as fast."""

from typing import Final

TUNED_FREQUENCY: Final = 575.9586531581288
"""Electrical frequency at base speed that times and rates are tuned for (rad/s); they are scaled for other drives."""
BANDWIDTH: Final = 80.0
"""Bandwidth at that frequency (1/s). An encoder's steps of speed become current, which limits both rates."""
INTEGRAL_RATE: Final = 15.0
"""Rate of the integral at that frequency (1/s)."""
TUNED_TIME: Final = 0.0913
"""Time in which rated power accelerates the shaft to base speed (s), below which the rates grow in proportion."""
FASTEST_OF_FREQUENCY: Final = 3.5
"""Greatest multiple of the rates at the electrical frequency (1)."""
