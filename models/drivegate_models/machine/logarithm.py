"""The logarithm near one, from operations that every processor rounds identically; those of libraries differ."""

from __future__ import annotations

from typing import Final

from drivegate_models.compilation.kernels import inlined

GREATEST: Final = 0.65
"""Maximum argument for which the series is exact to rounding."""

# With s = x / (2 + x): ln(1 + x) = 2 artanh s = 2 s + s R, R = 2 s**2/3 + 2 s**4/5 + ..., and 2 s = x - s x.
_C0, _C1, _C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10, _C11 = (2.0 / (2 * k + 3) for k in range(12))


@inlined
def logarithm_ratio(x: float) -> float:
    """Return ``ln(1 + x) / x``, which is 1 at zero, within one unit in the last place.

    The argument is from 0 to `GREATEST`. ``ln(1 + x) = x - s (x - R)`` as in fdlibm, divided by x: the correction
    to 1 is at most a quarter, so its own rounding is negligible. The series ends where its next term is below
    1e-17.
    """
    divisor = 2.0 + x
    share = x / divisor
    z = share * share
    z2 = z * z
    z4 = z2 * z2
    low = (_C0 + _C1 * z) + z2 * (_C2 + _C3 * z)
    middle = (_C4 + _C5 * z) + z2 * (_C6 + _C7 * z)
    high = (_C8 + _C9 * z) + z2 * (_C10 + _C11 * z)
    series = z * (low + z4 * (middle + z4 * high))
    return 1.0 - (x - series) / divisor
