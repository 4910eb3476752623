"""When clocks of firmware wrap around."""

from __future__ import annotations

from typing import Final

_FIRST_S: Final = 3.0
"""Time of a clock that every run reaches, or a good part of it (s)."""
_MICROSECONDS: Final = 1e-6
_MILLISECONDS: Final = 1e-3
_BITS: Final = (15, 16, 24, 31, 32)
"""Bits of whole numbers without and with a sign, and of a number in single precision."""


def wraps_s(control_period_s: float) -> tuple[float, ...]:
    """List when clocks wrap around, or have too few bits: of µs, ms and control periods (s).

    Those of the first seconds are left out, since every run reaches them.
    """
    units = (_MICROSECONDS, _MILLISECONDS, control_period_s)
    times = {round(unit * float(1 << bits), 6) for unit in units for bits in _BITS}
    return tuple(sorted(time for time in times if time > _FIRST_S))
