"""The edges of the gates within a control period: initial gates, the next relevant edge, and passing it."""

from __future__ import annotations

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.rotor_frame import RotorFrame, phase_current
from drivegate_models.pm_ac.plant.circuit import Circuit, leg_voltages
from drivegate_models.pm_ac.plant.modulator import BLANKED, Gates
from drivegate_models.pm_ac.plant.settling import Legs, set_gate

# Current of a held leg that can be rounding, relative to the current in the rotor frame.
_NO_CURRENT = 1e-10


@inlined
def _change_gate(circuit: Circuit, legs: Legs, leg: int, gate: int) -> float:
    """Change a gate, and return the loss of its switches (J); only the switch that carries the current has one."""
    was_on = legs.gates[leg] != BLANKED and legs.gates[leg] == legs.signs[leg]
    is_on = gate != BLANKED and gate == legs.signs[leg]
    set_gate(circuit, legs, leg, gate)
    if was_on == is_on:
        return 0.0
    return circuit.turn_on_energy if is_on else circuit.turn_off_energy


@inlined
def begin_schedule(circuit: Circuit, legs: Legs, gates: Gates, frame: RotorFrame, duration: float) -> float:
    """Set the first gates, mark legs whose current cannot change its sign in the advance, and return the loss (J)."""
    lost = 0.0
    reach = circuit.steepest * duration
    none = _NO_CURRENT * (abs(frame.direct) + abs(frame.quadrature))
    for leg in range(3):
        legs.positions[leg] = 0
        lost += _change_gate(circuit, legs, leg, gates.gates[leg, 0])
        current = phase_current(frame, leg)
        if legs.signs[leg] == 0 and abs(current) > none:
            # The caller has changed the currents since the leg was held.
            legs.signs[leg] = 1 if current > 0.0 else -1
        legs.sure[leg] = 0
        if abs(current) > reach:
            legs.sure[leg] = 1 if current > 0.0 else -1
    return lost


@inlined
def following_edge(circuit: Circuit, gates: Gates, leg: int, position: int, sign: int, voltage: float) -> int:
    """Return the number of the next edge that changes a leg's voltage at a sign of its current (0 for either)."""
    following = position + 1
    while following < gates.counts[leg] and sign != 0:
        low, high = leg_voltages(circuit, gates.gates[leg, following])
        if (low if sign > 0 else high) != voltage:
            break
        following += 1
    return int(following)


@inlined
def _following(circuit: Circuit, legs: Legs, gates: Gates, leg: int, sign: int) -> int:
    """Return the number of the next edge that changes a leg's present voltage at a sign of its current."""
    return following_edge(circuit, gates, leg, legs.positions[leg], sign, legs.voltages[leg])


@inlined
def sooner(gates: Gates, leg: int, number: int, limit: float) -> float:
    """Return the time of a leg's edge by its number, or a limit that comes before it (s)."""
    return min(limit, gates.times[leg, number]) if number < gates.counts[leg] else limit


@inlined
def pass_before(circuit: Circuit, legs: Legs, gates: Gates, leg: int, number: int) -> None:
    """Pass the edges of a leg before the one with a number, which have no effect."""
    if number > legs.positions[leg] + 1:
        legs.positions[leg] = number - 1
        set_gate(circuit, legs, leg, gates.gates[leg, number - 1])


@inlined
def distant_edge(circuit: Circuit, legs: Legs, gates: Gates, duration: float) -> float:
    """Return the time of the next change of a leg's voltage by its gate, if no current changes its sign (s)."""
    limit = duration
    for leg in range(3):
        following = _following(circuit, legs, gates, leg, legs.signs[leg])
        limit = sooner(gates, leg, following, limit)
    return limit


@inlined
def next_edge(circuit: Circuit, legs: Legs, gates: Gates, duration: float) -> float:
    """Pass the edges without effect, and return the time of the next change of a leg's voltage by its gate (s)."""
    limit = duration
    for leg in range(3):
        following = _following(circuit, legs, gates, leg, legs.sure[leg])
        pass_before(circuit, legs, gates, leg, following)
        limit = sooner(gates, leg, following, limit)
    return limit


@inlined
def pass_edges(circuit: Circuit, legs: Legs, gates: Gates, time: float) -> float:
    """Change all gates that change up to a time (s), and return the loss of their switches (J)."""
    lost = 0.0
    for leg in range(3):
        following = legs.positions[leg] + 1
        while following < gates.counts[leg] and gates.times[leg, following] <= time:
            legs.positions[leg] = following
            lost += _change_gate(circuit, legs, leg, gates.gates[leg, following])
            following += 1
    return lost
