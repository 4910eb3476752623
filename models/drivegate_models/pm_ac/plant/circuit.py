"""Constants of an advance, and relations of currents and voltages between legs and rotor frame."""

from __future__ import annotations

from math import sqrt
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.rotor_frame import RotorFrame, axis_of, from_phases
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.plant.modulator import LOWER, UPPER

UNBOUNDED: Final = 1e200
"""Value of a missing bound of slopes; finite, so that its product with zero time is zero."""
_STANDSTILL = 1e-100
_TIE = 1e-13
_ROUNDING = 1e-16


class Circuit(NamedTuple):
    """Constants of machine and bridge over one advance."""

    resistance: float
    """Winding resistance of a phase (ohm)."""
    direct: float
    """d-axis inductance (H)."""
    quadrature: float
    """q-axis inductance (H)."""
    flux: float
    """Peak flux linkage by the magnet (V s)."""
    electrical: float
    """Electrical speed (rad/s)."""
    link: float
    """Voltage of the link (V)."""
    switch_drop: float
    """Forward drop of a switch (V)."""
    diode_drop: float
    """Forward drop of a diode (V)."""
    turn_on_energy: float
    """Loss of a switch that turns on with a current (J)."""
    turn_off_energy: float
    """Loss of a switch that turns off with a current (J)."""
    rate: float
    """Fastest rate of the equations, |w| + R/min L (1/s)."""
    pace: float
    """Bound of the rate of change of phase current slopes, relative to the bound of the slopes (1/s)."""
    steepest: float
    """Bound of the slope of any phase current in the advance (A/s)."""
    bend: float
    """Bound of the slope's own slope while no leg is held (A/s2)."""
    tie: float
    """Voltage difference that is zero except for rounding (V)."""
    nothing: float
    """Current that builds up within the rounding of time (A), and so counts as zero."""


@inlined
def circuit_of(
    drive: PmAcDrive, speed: float, link: float, direct: float, quadrature: float, duration: float
) -> Circuit:
    """Return the constants of an advance.

    - `speed`: shaft speed (rad/s).
    - `link`: voltage of the dc link (V).
    - `direct`, `quadrature`: d-axis and q-axis currents at the start (A).
    - `duration`: length of the advance (s).
    - Result: its bound of slopes is `UNBOUNDED` if the currents may change completely in the advance.
    """
    electrical = drive.pole_pairs * speed
    if abs(electrical) < _STANDSTILL:
        electrical = 0.0
    least = min(drive.direct_inductance, drive.quadrature_inductance)
    greatest = max(drive.direct_inductance, drive.quadrature_inductance)
    per_least = 1.0 / least
    turning = abs(electrical)
    # In the stationary frame, speed alone drives currents only in a salient machine.
    growth = (drive.resistance + turning * (greatest - least)) * per_least
    pace = growth + 4.0 * turning
    # The leg voltages are between -V_D and V + V_D, or, with a link below the switches' drop, between V - V_S and V_S.
    span = link + 2.0 * max(drive.diode_drop, drive.switch_drop)
    voltage = (2.0 / 3.0) * span + turning * abs(drive.magnet_flux)
    steepest = UNBOUNDED
    if growth * duration <= 0.5:
        forced = (2.0 / 3.0) * span * per_least + turning * abs(
            drive.magnet_flux
        ) / drive.quadrature_inductance
        # e**x is at most 1 + 2 x up to a half.
        size = (sqrt(direct * direct + quadrature * quadrature) + forced * duration) * (
            1.0 + 2.0 * growth * duration
        )
        steepest = forced + growth * size
    return Circuit(
        drive.resistance,
        drive.direct_inductance,
        drive.quadrature_inductance,
        drive.magnet_flux,
        electrical,
        link,
        drive.switch_drop,
        drive.diode_drop,
        drive.turn_on_energy,
        drive.turn_off_energy,
        turning + drive.resistance * per_least,
        pace,
        steepest,
        pace * steepest,
        _TIE * voltage,
        _ROUNDING * voltage * per_least * duration,
    )


@inlined
def sagitta(circuit: Circuit, length: float) -> float:
    """Return the maximum distance of a phase current from its chord in a segment (s) without a held leg (A)."""
    return 0.125 * circuit.bend * length * length


@inlined
def has_drops(circuit: Circuit) -> bool:
    """Return True if switches or freewheeling diodes have a forward drop."""
    return circuit.switch_drop != 0.0 or circuit.diode_drop != 0.0


@inlined
def leg_voltages(circuit: Circuit, gate: int) -> tuple[float, float]:
    """Return the voltages of a leg relative to the lower rail, for positive and for negative current (V)."""
    if gate == UPPER:
        return circuit.link - circuit.switch_drop, circuit.link + circuit.diode_drop
    if gate == LOWER:
        return -circuit.diode_drop, circuit.switch_drop
    return -circuit.diode_drop, circuit.link + circuit.diode_drop


@inlined
def is_on_upper_rail(gate: int, sign: int) -> bool:
    """Return True if a leg's current, of this sign, is from the upper rail."""
    return gate == UPPER or (gate != LOWER and sign < 0)


@inlined
def drop_of(circuit: Circuit, gate: int, sign: int) -> float:
    """Return the forward drop of the device that carries a leg's current (V); 0 for a leg without current."""
    if sign == 0:
        return 0.0
    return circuit.switch_drop if gate == sign else circuit.diode_drop


@inlined
def rotor_voltages(frame: RotorFrame, first: float, second: float, third: float) -> tuple[float, float]:
    """Return the d-axis and q-axis voltages for the voltages of three legs (V)."""
    along, across = from_phases(first, second, third)
    return (
        frame.cosine * along + frame.sine * across,
        frame.cosine * across - frame.sine * along,
    )


@inlined
def current_slopes(
    circuit: Circuit, frame: RotorFrame, direct: float, quadrature: float
) -> tuple[float, float]:
    """Return the slopes of the d-axis and q-axis currents for d-axis and q-axis voltages (A/s)."""
    return (
        (
            direct
            - circuit.resistance * frame.direct
            + circuit.electrical * circuit.quadrature * frame.quadrature
        )
        / circuit.direct,
        (
            quadrature
            - circuit.resistance * frame.quadrature
            - circuit.electrical * (circuit.direct * frame.direct + circuit.flux)
        )
        / circuit.quadrature,
    )


@inlined
def phase_slope(
    circuit: Circuit, frame: RotorFrame, leg: int, first: float, second: float, third: float
) -> float:
    """Return the slope of a phase current for the voltages of three legs (A/s)."""
    voltages = rotor_voltages(frame, first, second, third)
    direct, quadrature = current_slopes(circuit, frame, voltages[0], voltages[1])
    cosine, sine = axis_of(frame, leg)
    return cosine * (direct - circuit.electrical * frame.quadrature) - sine * (
        quadrature + circuit.electrical * frame.direct
    )


@inlined
def holding_voltage(
    circuit: Circuit, frame: RotorFrame, leg: int, voltages: NDArray[np.float64]
) -> tuple[float, float]:
    """Return the voltage of a leg for constant current (V), and the slope per voltage there (A/(V s)).

    `leg`: index of the leg. `voltages`, shape (3,): voltages of the legs (V); that of this leg is not used. Returns
    `voltage`, `gain`: the gain is positive.
    """
    first = 0.0 if leg == 0 else voltages[0]
    second = 0.0 if leg == 1 else voltages[1]
    third = 0.0 if leg == 2 else voltages[2]
    slope = phase_slope(circuit, frame, leg, first, second, third)
    cosine, sine = axis_of(frame, leg)
    gain = (2.0 / 3.0) * (cosine * cosine / circuit.direct + sine * sine / circuit.quadrature)
    return -slope / gain, gain
