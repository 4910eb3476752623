"""The proportional-integral speed regulator (paper, Fig. 2 and "Implementation") with anti-windup."""

from __future__ import annotations

from drivegate_models.compilation.kernels import inlined


@inlined
def regulate_speed(
    error: float, integral: float, proportional: float, integral_step: float, limit: float
) -> tuple[float, float]:
    """Return the current reference, from 0 to `limit`, and the new integral (A).

    `error` is speed reference minus speed (rad/s), `proportional` the gain, and `integral_step` the integral gain times
    the control period (both A s/rad). The integral stays constant while the output is limited in the error's direction.
    """
    following = min(max(integral + integral_step * error, 0.0), limit)
    reference = proportional * error + following
    # At a limit the integral may only decrease in magnitude; otherwise the speed overshoots until it is unwound.
    if reference > limit:
        return limit, min(integral, following) if error > 0.0 else following
    if reference < 0.0:
        return 0.0, max(integral, following) if error < 0.0 else following
    return reference, following
