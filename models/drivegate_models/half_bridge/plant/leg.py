"""Connection of a phase by its half-bridge leg: a rail, floating, or the ideal regulator's slide along i*."""

from __future__ import annotations

from drivegate_models.compilation.kernels import inlined


@inlined
def ideal_latch(
    along: float, reference: float, depart: int, needed: float, front: float, back: float
) -> tuple[int, int, bool]:
    """Return the switch state of the ideal regulator (without hysteresis band).

    - `along`: current times the sector's sign (A).
    - `reference`: current reference i* (A).
    - `depart`: direction in which a slide has just ended, times the sector's sign: 1, -1, or 0 for none.
    - `needed`: terminal voltage times the sector's sign that maintains the current (V).
    - `front`, `back`: maximum and minimum terminal voltage times the sector's sign (V).
    - Returns `latch`: 1 for the switch on, 0 for off; `depart`: direction in which the current must leave the
      reference, 0 for none; `slides`: true if the current slides along the reference.
    """
    # An exact comparison is sufficient: an event at i* sets the current to i* itself.
    if along != reference:
        return (1 if along < reference else 0), depart, False
    # A current that has just left still equals i*; if it counted as sliding, it would never leave.
    if depart != 0:
        return (1 if depart < 0 else 0), depart, False
    # Beyond a rail no duty ratio maintains the current.
    if needed > front:
        return 1, -1, False
    if needed < back:
        return 0, 1, False
    return 1, 0, True


@inlined
def connection(
    gate: int,
    current: float,
    starting: int,
    emf: float,
    emf_rate: float,
    upper: float,
    lower: float,
    switch_drop: float,
    diode_drop: float,
) -> tuple[int, int]:
    """Return the rail of a phase, and the sign of its current until the next event.

    - `gate`: switch that is on: 1 upper, -1 lower, 0 none.
    - `current`: phase current at the last event (A).
    - `starting`: sign of a current that has just begun to flow in a floating phase, or 0.
    - `emf`, `emf_rate`: back-EMF (V) and its slope (V/s).
    - `upper`, `lower`: voltages of the half-sources (V).
    - `switch_drop`, `diode_drop`: forward drops of switch and diode (V).
    - Returns `rail`: 1 upper, -1 lower, 0 for a floating phase; `side`: sign of the current, 0 if none flows.
    """
    # A current that begins is still zero; without its direction, the phase would continue to float.
    side = starting
    if current > 0.0:
        side = 1
    elif current < 0.0:
        side = -1
    if gate == 0:
        if side == 0:
            # Rectifying: the back-EMF drives current into a rail through that rail's diode.
            # At equality, where the preceding event has ended, only the slope determines the direction.
            if emf > upper + diode_drop or (emf == upper + diode_drop and emf_rate > 0.0):
                side = -1
            elif emf < -(lower + diode_drop) or (emf == -(lower + diode_drop) and emf_rate < 0.0):
                side = 1
        # With the gates off a current can only continue through a diode, against that rail's voltage.
        return -side, side
    if side == 0:
        source = upper if gate > 0 else lower
        opposing = gate * emf
        if opposing < source - switch_drop:
            side = gate
        elif opposing > source + diode_drop:
            side = -gate
        # Without drops there is no dead zone: at equality the slope decides.
        elif switch_drop + diode_drop == 0.0:
            side = -gate if gate * emf_rate > 0.0 else gate
        else:
            # Between the drops of switch and diode nothing flows.
            return 0, 0
    return gate, side


@inlined
def time_to_pass(value: float, rate: float, low: float, high: float) -> float:
    """Return the time at which a straight line leaves a band.

    `value`, `rate`: present value and its slope (unit of the value, and per second). `low`, `high`: ends of the band,
    in the unit of the value. Result: time from now (s), negative if the value is outside already, 1e300 without a
    slope.
    """
    if rate > 0.0:
        return (high - value) / rate
    if rate < 0.0:
        return (low - value) / rate
    return 1e300
