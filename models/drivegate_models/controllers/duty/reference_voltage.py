"""Voltage that reference currents may use; the rest is reserved for the regulators."""

from __future__ import annotations

from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.current_regulator import BANDWIDTH

VOLTAGE_SHARE: Final = 0.98
"""Share of the undistorted voltage for the reference currents; the rest is reserved for the current regulators."""

# Rate of field weakening by the voltage in use, relative to that of the currents; minimum share of the undistorted
# voltage for the references; and maximum voltage in use, because a step needs its voltage only for a short time.
_WEAKENING_RATE = 0.02
_LEAST_SHARE = 0.5
_MOST_USED = 1.5
# Voltage reserve of a speed regulator during braking, the share of the maximum torque from which it is complete, and
# the greatest share of the voltage beyond that of the weakest field, which is all that torque has. With the share for
# the current regulators it is less than a tenth: where more is free, the field is not weakened.
_BRAKING_RESERVE = 0.05
_WHOLE_RESERVE_FROM = 0.2
_GREATEST_RESERVE = 0.5


@inlined
def reset_voltage_share(state: Any) -> None:
    state.weakening_step = _WEAKENING_RATE * BANDWIDTH
    state.voltage_share = VOLTAGE_SHARE


@inlined
def with_reserve(
    state: Any, torque: float, requested: float, electrical: float, voltage: float
) -> tuple[float, float]:
    """Return the voltage for reference currents (V), and the resistance by which they are chosen (ohm).

    - `torque`: signed torque that is asked for (N m).
    - `requested`: its magnitude, at most the maximum torque (N m).
    - `electrical`: electrical speed (rad/s).
    - `voltage`: voltage without a reserve for braking (V).
    """
    if torque * electrical >= 0.0:
        return voltage, state.resistance
    if state.regulates_speed == 0:
        # The voltage across the resistance helps to brake.
        return voltage, -state.resistance
    # Braking currents beyond the voltage limit move further away from their references, on a machine of other
    # inductances and flux too, so that what the resistance helps is not counted on here.
    braking = min(requested / (_WHOLE_RESERVE_FROM * state.greatest_torque), 1.0)
    weakest = state.magnet_flux + state.direct_inductance * state.deepest
    left = max(voltage - abs(electrical) * max(weakest, 0.0), 0.0)
    return voltage - min(_BRAKING_RESERVE * braking * voltage, _GREATEST_RESERVE * left), state.resistance


@inlined
def share_voltage(state: Any, used: float) -> None:
    """Reduce the voltage of the next references while the regulators use more than intended; otherwise increase it.

    `used`: requested voltage over the undistorted one (1). After Kim and Sul, "Speed control of interior permanent
    magnet synchronous motor drive for the flux weakening operation", IEEE Transactions on Industry Applications 33(1),
    1997: the voltage requested by the regulators shows the field weakening that a machine with other than nominal data
    needs.
    """
    spare = 0.5 * (1.0 + VOLTAGE_SHARE) - min(used, _MOST_USED)
    share = state.voltage_share + state.weakening_step * spare
    state.voltage_share = min(max(share, _LEAST_SHARE), VOLTAGE_SHARE)
