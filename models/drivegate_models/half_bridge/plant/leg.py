"""What a half-bridge leg connects its phase to: rail, floating, or the ideal regulator's slide along i*."""

from __future__ import annotations

from drivegate_models.compilation.kernels import inlined


@inlined
def ideal_latch(
    along: float, reference: float, depart: int, needed: float, front: float, back: float
) -> tuple[int, int, bool]:
    """Return what the ideal regulator (no band) does with its switch.

    Parameters
    ----------
    along : float
        Current along the sector's sign (A).
    reference : float
        Current reference (A).
    depart : int
        Direction in which a slide has just been left, along the sector's sign: 1, -1, or 0 for none.
    needed : float
        Terminal voltage along the sector's sign that would hold the current (V).
    front, back : float
        Greatest and least terminal voltage along the sector's sign (V).

    Returns
    -------
    latch : int
        1 for the switch on, 0 for off.
    depart : int
        The direction in which the current leaves the reference, if it has to.
    slides : bool
        Whether the current is held at the reference.
    """
    # An exact comparison will do: an event at i* sets the current to i* itself.
    if along != reference:
        return (1 if along < reference else 0), depart, False
    # A current that has just left still equals i*; taken for sliding, it would never get away.
    if depart != 0:
        return (1 if depart < 0 else 0), depart, False
    # Beyond a rail no share of switching holds the current.
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
    """Return the rail that a phase is connected to, and the sign of its current until the next event.

    Parameters
    ----------
    gate : int
        Switch that is on: 1 upper, -1 lower, 0 none.
    current : float
        Phase current (A).
    starting : int
        Sign of the current that a floating phase has just begun to carry, or 0.
    emf, emf_rate : float
        Back-EMF (V) and its slope (V/s).
    upper, lower : float
        Voltages of the half-sources (V).
    switch_drop, diode_drop : float
        Forward drops (V).

    Returns
    -------
    rail : int
        1 upper, -1 lower, 0 for a phase that floats.
    side : int
        Sign of the current, 0 for none.
    """
    # A current that begins is still zero; its direction has to come with it, or the phase would float on.
    side = starting
    if current > 0.0:
        side = 1
    elif current < 0.0:
        side = -1
    if gate == 0:
        if side == 0:
            # Rectifying: the back-EMF drives current into a rail through that rail's diode.
            # At equality, where the event that leads here has ended, only the slope says which way it goes.
            if emf > upper + diode_drop or (emf == upper + diode_drop and emf_rate > 0.0):
                side = -1
            elif emf < -(lower + diode_drop) or (emf == -(lower + diode_drop) and emf_rate < 0.0):
                side = 1
        # With the gates off a current can only flow on through a diode, against the rail that it ends at.
        return -side, side
    if side == 0:
        source = upper if gate > 0 else lower
        opposing = gate * emf
        if opposing < source - switch_drop:
            side = gate
        elif opposing > source + diode_drop:
            side = -gate
        # Without drops there is no dead zone to rest in: at equality the slope decides.
        elif switch_drop + diode_drop == 0.0:
            side = -gate if gate * emf_rate > 0.0 else gate
        else:
            # Between the drops of switch and diode nothing flows.
            return 0, 0
    return gate, side


@inlined
def time_to_pass(value: float, rate: float, low: float, high: float) -> float:
    """Return when a straight line leaves a band, or infinity.

    Parameters
    ----------
    value, rate : float
        Value now and its slope a second.
    low, high : float
        The band.

    Returns
    -------
    float
        Time (s), negative where it is outside already.
    """
    if rate > 0.0:
        return (high - value) / rate
    if rate < 0.0:
        return (low - value) / rate
    return 1e300
