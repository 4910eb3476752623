"""The steady state of a turning machine with all legs off, which is the initial state of a run."""

from __future__ import annotations

from math import ceil, nan, pi, sqrt
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.loop.shaft import within_a_turn
from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.machine.rotor_frame import PER_ROOT_THREE
from drivegate_models.pm_ac.plant.advance import PmAcPhases, follow_period
from drivegate_models.pm_ac.plant.dc_link import BATTERY, VOLTAGE, LinkState, charge_link, is_ideal
from drivegate_models.pm_ac.plant.drive import CENTRED, PmAcDrive, drifted
from drivegate_models.pm_ac.plant.linked_advance import advance_linked_period

MOST_TURNS: Final = 200
"""Maximum number of electrical turns until the currents are periodic."""
PERIODIC: Final = 1e-9
"""Change of the currents over a turn, relative to the current limit, below which they are periodic (1)."""

# Minimum number of parts of an electrical turn; the currents repeat every sixth of a turn.
_FEWEST_PARTS = 6


@inlined
def rectifies(drive: PmAcDrive, speed: float, link: float) -> bool:
    """Return True if the diodes conduct while all legs are off.

    `speed`: shaft speed, of either sign (rad/s). `link`: voltage of the dc link (V). Result: true if the peak
    line-to-line EMF exceeds the link voltage plus the drops of two diodes.
    """
    emf = drive.pole_pairs * abs(speed) * drive.magnet_flux
    return emf > (link + 2.0 * drive.diode_drop) * PER_ROOT_THREE


@inlined
def _charge_by_rectifying(drive: PmAcDrive, link: LinkState, speed: float) -> None:
    """Charge the link of a source that takes nothing back to the peak of the line-to-line EMF, less two diodes' drops.

    `speed`: shaft speed, of either sign (rad/s). A chopper limits that to its upper threshold.
    """
    constants = drive.dc_link
    if constants.source == BATTERY:
        return
    peak = drive.pole_pairs * abs(speed) * drive.magnet_flux / PER_ROOT_THREE - 2.0 * drive.diode_drop
    if constants.chopper_conductance > 0.0:
        peak = min(peak, constants.chopper_on)
    link.state[VOLTAGE] = max(link.state[VOLTAGE], peak)


@unallocating
def settle_rectifying(
    drive: PmAcDrive,
    phases: PmAcPhases,
    angle: float,
    speed: float,
    link: float,
    factors: tuple[float, float],
    longest: float,
    ratios: NDArray[np.float64],
    legs: NDArray[np.int64],
    totals: NDArray[np.float64],
) -> int:
    """Turn the shaft with all legs off until the currents are periodic.

    Below the speed at which the diodes conduct, the state is not changed.

    - `angle`: electrical angle at the start and the end of every turn (rad).
    - `speed`: shaft speed, of either sign (rad/s).
    - `link`: voltage of the dc link, or of its source unless the link is ideal (V).
    - `factors`: on the winding resistance and on the magnet's flux (1).
    - `longest`: maximum length of a part that is computed at once (s).
    - `ratios`, shape (3,): duty ratios, all zero.
    - `legs`, shape (3,): `LEG_OFF` of the contract for each leg.
    - `totals`, shape (ledger.ENTRIES,): receives the exact integrals over the last turn.
    - Result: `COMPLETED`, or the status with which the plant's advance failed.
    """
    plant = drifted(drive, factors[0], factors[1])
    if not rectifies(plant, speed, link):
        return COMPLETED
    has_ideal_link = is_ideal(drive.dc_link)
    if not has_ideal_link:
        charge_link(phases.dc_link, link)
        _charge_by_rectifying(plant, phases.dc_link, speed)
    turn = 2.0 * pi / (drive.pole_pairs * abs(speed))
    parts = max(ceil(turn / longest), _FEWEST_PARTS)
    part_angle = 2.0 * pi / parts if speed > 0.0 else -2.0 * pi / parts
    for _ in range(MOST_TURNS):
        direct, quadrature = phases.rotor_currents[0], phases.rotor_currents[1]
        for entry in range(ledger.ENTRIES):
            totals[entry] = 0.0
        for part in range(parts):
            begin = within_a_turn(angle + part * part_angle)
            if has_ideal_link:
                status = follow_period(
                    plant, phases, begin, speed, link, ratios, legs, CENTRED, turn / parts, totals
                )
            else:
                status = advance_linked_period(
                    plant, phases, begin, speed, link, ratios, legs, nan, CENTRED, turn / parts, totals
                )
            if status != COMPLETED:
                return int(status)
        direct -= phases.rotor_currents[0]
        quadrature -= phases.rotor_currents[1]
        if sqrt(direct * direct + quadrature * quadrature) <= PERIODIC * drive.current_limit:
            break
    return COMPLETED
