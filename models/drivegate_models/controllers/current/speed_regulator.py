"""The proportional-integral speed regulator (paper, Fig. 2 and "Implementation") with anti-windup."""

from __future__ import annotations

from drivegate_models.compilation.kernels import inlined


@inlined
def regulate_speed(
    error: float, integral: float, proportional: float, integral_step: float, limit: float
) -> tuple[float, float]:
    """Return the current reference and the regulator's new integral.

    Parameters
    ----------
    error : float
        Speed reference minus speed (rad/s).
    integral : float
        The regulator's integral (A).
    proportional : float
        Gain (A s/rad).
    integral_step : float
        Integral gain times control period (A s/rad).
    limit : float
        Greatest current reference (A).

    Returns
    -------
    reference : float
        Current reference, 0 to `limit` (A).
    integral : float
        The new integral (A), 0 to `limit`. It stands still while the output is limited in the error's direction.
    """
    following = min(max(integral + integral_step * error, 0.0), limit)
    reference = proportional * error + following
    # Limited, the integral may come back but not go on; the speed would overshoot until it is unwound.
    if reference > limit:
        return limit, min(integral, following) if error > 0.0 else following
    if reference < 0.0:
        return 0.0, max(integral, following) if error < 0.0 else following
    return reference, following
