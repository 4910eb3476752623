"""Faulty controllers of duty ratios: field-oriented control with other constants, and the checks that catch them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, radians, sqrt
from typing import Any, Final

from drivegate_models.contract.duty.signals import SPEED_REFERENCE, TORQUE_REFERENCE, DutyNameplate

STUCK_SHARE: Final = 0.3
"""Weakening that stays on, over the current limit (1)."""
_LITTLE_SALIENCY: Final = 1.5
"""Ratio of inductances up to which the wrong axis costs less current than MTP-1 allows (1)."""

ENCODER_EDGES: Final = 10_000
"""Edges a turn of the encoder whose counter is too short; 16 bits are no whole number of its turns."""


@dataclass(frozen=True)
class DutyFault:
    """A fault that is made by changing the controller's nameplate or its state, or its senses and answers."""

    check: str
    """Check that must catch it."""
    sentence: str
    """What the controller does wrong."""
    believes: Callable[[DutyNameplate], DutyNameplate] | None = None
    """From a nameplate to the one that the controller is given."""
    alter: Callable[[Any], None] | None = None
    """Changes the record of the state, just reset."""
    perturbed: Callable[[DutyNameplate], dict[str, float]] | None = None
    """Return the changed fields of `PERTURBED_STATE` for a nameplate."""
    keeps: tuple[str, ...] = ()
    """Fields of either state that a reset leaves as they are."""
    less_salient: tuple[float, str] | None = None
    """Ratio of the inductances across the magnet's axis and along it up to which another check must catch it,
    and that check: the less reluctance torque there is, the less torque and current a wrong angle or
    inductance costs."""

    @property
    def kind(self) -> str:
        """What kind of fault it is; the self-test counts by kind."""
        if self.keeps:
            return "Instances and resets"
        if self.believes is not None:
            return "Wrong numbers of the drive"
        return "Regulation" if self.alter is not None else "Senses and answers"

    def check_on(self, plate: DutyNameplate) -> str:
        """State which check must catch it on a drive."""
        ratio = plate.quadrature_inductance / plate.direct_inductance
        return (
            self.check if self.less_salient is None or ratio > self.less_salient[0] else self.less_salient[1]
        )

    def idles_on(self, plate: DutyNameplate) -> bool:
        """Return True if a controller with a wrong nameplate gets the true one on this drive."""
        # A drive without dead time is also run with some, which is on the nameplate then.
        blanked = plate._replace(dead_time=plate.dead_time or plate.control_period)
        return self.believes is not None and self.believes(blanked) == blanked


def _scaled(factor: float, *fields: str) -> Callable[[Any], None]:
    def alter(state: Any) -> None:
        for field in fields:
            # Not in place: a count of periods stays a whole number.
            state[field] = state[field] * factor

    return alter


def _weakens_little(state: Any) -> None:
    """Allow a share of the weakening that a machine can use: more than that costs it little torque."""
    state["deepest"] = 0.3 * max(state["deepest"], -state["magnet_flux"] / state["direct_inductance"])


def _unseen_along(share: float) -> Callable[[DutyNameplate], dict[str, float]]:
    """Hide a current along the magnet's axis from the controller, of a share of the limit against the magnet."""

    def perturbed(plate: DutyNameplate) -> dict[str, float]:
        return {"direct_added": share * plate.current_limit, "pole_pairs": float(plate.pole_pairs)}

    return perturbed


def _under(
    reference_kind: int, field: str, value: Callable[[DutyNameplate], float]
) -> Callable[[DutyNameplate], dict[str, float]]:
    """Set a field where the reference is of a kind."""

    def perturbed(plate: DutyNameplate) -> dict[str, float]:
        return {field: value(plate)} if plate.reference_kind == reference_kind else {}

    return perturbed


DUTY_FAULTS: Final = {
    "stuck-weakening": DutyFault(
        "FWK-2",
        "Weakens by 30 % of the current limit at all times.",
        perturbed=_unseen_along(STUCK_SHARE),
    ),
    "delay-turned-back": DutyFault(
        "FWK-3",
        "Turns its voltages back by the angle of the delay instead of ahead.",
        alter=_scaled(-1.0, "lead"),
    ),
    "wrong-pole-pairs": DutyFault(
        "ACC-1",
        "Counts one pole pair too many.",
        believes=lambda plate: plate._replace(pole_pairs=plate.pole_pairs + 1),
    ),
    "generous-current-limit": DutyFault(
        "OVC-1",
        "Takes a current limit that is 40 % too high.",
        believes=lambda plate: plate._replace(current_limit=1.4 * plate.current_limit),
    ),
    "lenient-current-limit": DutyFault(
        "OVC-2",
        "Takes a current limit that is 10 % too high.",
        believes=lambda plate: plate._replace(current_limit=1.1 * plate.current_limit),
    ),
    "weak-magnets-assumed": DutyFault(
        "ACC-1",
        "Converts torque to current with 80 % of the magnet's flux.",
        believes=lambda plate: plate._replace(magnet_flux=0.8 * plate.magnet_flux),
    ),
    "saliency-ignored": DutyFault(
        "MTP-1",
        "Takes the inductance of the magnet's axis for both axes.",
        believes=lambda plate: plate._replace(quadrature_inductance=plate.direct_inductance),
        less_salient=(_LITTLE_SALIENCY, "FWK-2"),
    ),
    "no-speed-integral": DutyFault(
        "ACC-1", "Regulates the speed by its error alone.", alter=_scaled(0.0, "speed_integral_step")
    ),
    "slow-currents": DutyFault(
        "STP-1",
        "Regulates its currents with a sixth of the gain.",
        alter=_scaled(
            1.0 / 6.0, "direct_gain", "quadrature_gain", "direct_integral_step", "quadrature_integral_step"
        ),
    ),
    "nervous-currents": DutyFault(
        "STP-1",
        "Regulates its currents with three times the gain.",
        alter=_scaled(3.0, "direct_gain", "quadrature_gain"),
    ),
    "angle-offset": DutyFault(
        "ACC-1",
        "Has an angle that is 5 electrical degrees off.",
        perturbed=lambda plate: {"angle_added": radians(5.0) / plate.pole_pairs},
        less_salient=(1.0, "FWK-2"),
    ),
    "current-sensor-offset": DutyFault(
        "ACC-1",
        "Reads the first phase current 15 % of the current limit too high.",
        perturbed=lambda plate: {"current_added": 0.15 * plate.current_limit},
    ),
    "current-sensor-gain": DutyFault(
        "ACC-1", "Reads its currents 10 % too high.", perturbed=lambda _plate: {"current_factor": 1.1}
    ),
    "speed-misread": DutyFault(
        "ACC-1", "Reads the speed 3 % too high.", perturbed=lambda _plate: {"speed_factor": 1.03}
    ),
    "supply-underestimated": DutyFault(
        "FWK-1",
        "Takes the link for 20 % less than it has, and weakens too early.",
        perturbed=lambda _plate: {"supply_factor": 0.8},
    ),
    "late-samples": DutyFault(
        "FWK-3", "Regulates with the currents of the step before.", perturbed=lambda _plate: {"is_late": 1.0}
    ),
    "unclamped-ratios": DutyFault(
        "DUT-1",
        "Stretches its duty ratios by a fifth after its limiter.",
        perturbed=lambda _plate: {"stretch": 1.2},
    ),
    "swapped-phases": DutyFault(
        "ACC-1",
        "Drives the third phase with the second one's ratio.",
        perturbed=lambda _plate: {"swaps_phases": 1.0},
    ),
    "long-period": DutyFault(
        "DUT-1",
        "Asks for a control period that is half as long again.",
        perturbed=lambda plate: {"next_period": 1.5 * plate.control_period},
    ),
    "swapped-axes": DutyFault(
        "MTP-1",
        "Swaps the inductances of the axes.",
        believes=lambda plate: plate._replace(
            direct_inductance=plate.quadrature_inductance, quadrature_inductance=plate.direct_inductance
        ),
        less_salient=(_LITTLE_SALIENCY, "FWK-2"),
    ),
    "reversed-currents": DutyFault(
        "OVC-1", "Reads its currents with the wrong sign.", perturbed=lambda _plate: {"current_factor": -1.0}
    ),
    "eager-integrals": DutyFault(
        "STP-1",
        "Regulates its currents with ten times the integral gain.",
        alter=_scaled(10.0, "direct_integral_step", "quadrature_integral_step"),
    ),
    "shy-current-limit": DutyFault(
        "FWK-1",
        "Takes a current limit that is 30 % too low.",
        believes=lambda plate: plate._replace(current_limit=0.7 * plate.current_limit),
    ),
    "strong-magnets-assumed": DutyFault(
        "FWK-2",
        "Counts on 30 % more of the magnet's flux, and weakens where the voltage is free.",
        believes=lambda plate: plate._replace(magnet_flux=1.3 * plate.magnet_flux),
        less_salient=(1.0, "ACC-1"),
    ),
    "resistance-overestimated": DutyFault(
        "FWK-1",
        "Takes five times the resistance, and leaves voltage unused for it.",
        believes=lambda plate: plate._replace(resistance=5.0 * plate.resistance),
    ),
    "direct-inductance-doubled": DutyFault(
        "ACC-1",
        "Takes twice the inductance of the magnet's axis.",
        believes=lambda plate: plate._replace(direct_inductance=2.0 * plate.direct_inductance),
    ),
    "slow-torque": DutyFault(
        "ACC-1",
        "Lets its torque follow the speed regulator at a hundredth of the rate.",
        alter=_scaled(0.01, "torque_step"),
    ),
    "field-strengthened": DutyFault(
        "FWK-2",
        "Strengthens the field by 10 % of the current limit.",
        perturbed=_unseen_along(-0.1),
    ),
    "shallow-weakening": DutyFault(
        "FWK-1",
        "Weakens by at most 30 % of what cancels the magnet's flux, or of the current limit.",
        alter=_weakens_little,
    ),
    "delay-overcompensated": DutyFault(
        "DEC-1",
        "Turns its voltages ahead by six times the delay.",
        alter=_scaled(6.0, "lead"),
    ),
    "shrunken-ratios": DutyFault(
        "FWK-1",
        "Gives 85 % of the voltage that it counts on.",
        perturbed=lambda _plate: {"stretch": 0.85},
    ),
    "third-current-computed": DutyFault(
        "SAF-1",
        "Computes the third current from the other two, and so misses a stuck sensor.",
        perturbed=lambda _plate: {"computes_third": 1.0},
    ),
    "dead-time-times-ten": DutyFault(
        "DTM-1",
        "Makes up for ten times the dead time.",
        believes=lambda plate: plate._replace(dead_time=10.0 * plate.dead_time),
    ),
    "small-current-offset": DutyFault(
        "RIP-4",
        "Reads the first phase current 3 % of the current limit too high.",
        perturbed=lambda plate: {"current_added": 0.03 * plate.current_limit},
    ),
    "clamped-phases": DutyFault(
        "STP-1",
        "Takes the link's voltage for half, and clamps each phase's duty ratio by itself.",
        perturbed=lambda _plate: {"stretch": 2.0, "clamps": 1.0},
    ),
    "swapped-hall-switches": DutyFault(
        "ACC-1",
        "Has two Hall switches swapped, so that its angle turns backward.",
        perturbed=lambda _plate: {"angle_factor": -1.0},
    ),
    "short-encoder-counter": DutyFault(
        "ACC-1",
        "Counts an encoder of 10,000 edges a turn in 16 bits.",
        perturbed=lambda _plate: {"wraps_after": 2.0 * pi * 2**16 / ENCODER_EDGES},
    ),
    "patient-stall-watch": DutyFault(
        "SAF-1",
        "Takes a standing shaft for locked only after four seconds under the greatest torque.",
        alter=_scaled(100, "stall_periods", "hall_stall_periods"),
    ),
    "hall-edges-counted": DutyFault(
        "SAF-1",
        "Counts Hall edges instead of reading states.",
        perturbed=lambda plate: {"counts_edges": 1.0, "pole_pairs": float(plate.pole_pairs)},
    ),
    "weak-braking": DutyFault(
        "ACC-1",
        "Limits a braking torque to 60 % of rated torque at base speed.",
        perturbed=_under(
            TORQUE_REFERENCE, "backward_limit", lambda plate: 0.6 * plate.rated_power / plate.base_speed
        ),
    ),
    "braking-cut-off": DutyFault(
        "ACC-1",
        "Refuses to brake above 105 % of the nominal link voltage.",
        perturbed=_under(TORQUE_REFERENCE, "braking_voltage", lambda plate: 1.05 * plate.supply_voltage),
    ),
    "slow-shaft-unseen": DutyFault(
        "ACC-1",
        "Takes the shaft for standing below 4 % of base speed.",
        perturbed=_under(SPEED_REFERENCE, "least_speed", lambda plate: 0.04 * plate.base_speed),
    ),
    "idle-speed-forced": DutyFault(
        "ACC-1",
        "Raises a speed reference below 6 % of base speed to that speed.",
        perturbed=_under(SPEED_REFERENCE, "least_reference", lambda plate: 0.06 * plate.base_speed),
    ),
    "light-rotor-assumed": DutyFault(
        "ROB-4",
        "Regulates the speed with 60 % of the gain, as for a lighter rotor.",
        alter=_scaled(0.6, "speed_gain"),
    ),
    "heavy-rotor-assumed": DutyFault(
        "ROB-4",
        "Regulates the speed with seven times the gains, as for a heavier rotor.",
        alter=_scaled(7.0, "speed_gain", "speed_integral_step"),
    ),
    "backward-refused": DutyFault(
        "ACC-1",
        "Takes a speed reference backward for standstill.",
        perturbed=_under(SPEED_REFERENCE, "backward_limit", lambda _plate: 0.0),
    ),
    "one-way-prediction": DutyFault(
        "SYM-1",
        "Predicts the angle for the delay of its voltages by the magnitude of the speed.",
        perturbed=_under(
            TORQUE_REFERENCE, "ahead", lambda plate: (plate.update_delay + 0.5) * plate.control_period
        ),
    ),
    "microseconds-signed": DutyFault(
        "ACC-1",
        "Ramps its reference up by a signed clock of microseconds, negative after 36 minutes.",
        perturbed=lambda plate: {"ramp": 100.0 * plate.control_period},
    ),
    "offsets-under-current": DutyFault(
        "RIP-4",
        "Takes the first currents below base speed for offsets, also after a restart.",
        perturbed=lambda plate: {"calibrates_below": plate.base_speed},
    ),
    "undervoltage-at-once": DutyFault(
        "ROB-5",
        "Turns its bridge off at one sample of less than half the link voltage.",
        perturbed=lambda plate: {"least_voltage": 0.5 * plate.supply_voltage},
    ),
    "jump-of-angle-believed": DutyFault(
        "SAF-1",
        "Does not notice the jump of the angle by a magnet that slips.",
        alter=_scaled(1000.0, "farthest_drift"),
    ),
    "hall-edge-awaited": DutyFault(
        "SAF-1",
        "Holds its angle at the sector's end where a Hall edge is missing.",
        alter=_scaled(0.0, "led_on_longest"),
    ),
    "braking-reserve": DutyFault(
        "FWK-2",
        "Plans braking currents with 20 % less of the link than there is.",
        perturbed=_under(TORQUE_REFERENCE, "braking_supply_factor", lambda _plate: 0.8),
    ),
    "overvoltage-ends-braking": DutyFault(
        "ACC-1",
        "Turns its bridge off above 112 % of the link's voltage while it brakes.",
        perturbed=_under(TORQUE_REFERENCE, "highest_voltage", lambda plate: 1.12 * plate.supply_voltage),
    ),
    "weakening-kept-near-base": DutyFault(
        "FWK-2",
        "Weakens from 97 % of base speed on, and in part down to 90 %.",
        perturbed=lambda plate: {
            "weakens_from": 0.97 * plate.base_speed,
            "weakens_until": 0.9 * plate.base_speed,
            "weakened_by": 0.25 * plate.current_limit,
            "pole_pairs": float(plate.pole_pairs),
        },
    ),
    "offsets-after-idling": DutyFault(
        "RIP-4",
        "Takes its currents for offsets after the load has vanished, also once it is back.",
        perturbed=lambda plate: {
            **_under(
                SPEED_REFERENCE, "idle_torque", lambda plate: 1.6 * plate.rated_power / plate.base_speed
            )(plate),
            "idle_noticed": 400.0,
            "idle_calibrated": 1300.0,
            "is_calibrated": 1.0,
            "calibrates_below": plate.base_speed,
        },
    ),
    "reference-clipped": DutyFault(
        "ACC-1",
        "Limits a speed reference to the highest speed.",
        perturbed=_under(SPEED_REFERENCE, "most_reference", lambda plate: plate.highest_speed),
    ),
    "speed-clipped": DutyFault(
        "ACC-1",
        "Reads no speed above 104 % of the highest.",
        perturbed=lambda plate: {"most_speed": 1.04 * plate.highest_speed},
    ),
    "lost-currents-trip": DutyFault(
        "ROB-5",
        "Turns its bridge off at one sample without currents.",
        perturbed=lambda plate: {"vanishing_current": 0.05 * plate.current_limit},
    ),
    "false-edges-trip": DutyFault(
        "ROB-5",
        "Turns its bridge off where the angle jumps by 2 electrical degrees.",
        perturbed=lambda plate: {
            "farthest_jump": radians(2.0) / plate.pole_pairs,
            "trips_at_jump": 1.0,
            "control_period": plate.control_period,
        },
    ),
    "phase-after-false-edges": DutyFault(
        "ROB-5",
        "Adds 120 electrical degrees where the angle jumps by 2.",
        perturbed=lambda plate: {
            "farthest_jump": radians(2.0) / plate.pole_pairs,
            "jump_taken_for": radians(120.0) / plate.pole_pairs,
            "control_period": plate.control_period,
        },
    ),
    "swinging-speed-trips": DutyFault(
        "ROB-5",
        "Turns its bridge off where the speed swings within a turn.",
        perturbed=lambda plate: {
            "loose_swing": 0.03 / plate.pole_pairs,
            # As if it had counted these before: a slow shaft swings less often in a run.
            "swings": 24.0,
            "control_period": plate.control_period,
        },
    ),
    "swings-damped-one-way": DutyFault(
        "ROB-5",
        "Damps swings of the speed, but only takes torque.",
        perturbed=_under(
            TORQUE_REFERENCE,
            "damping",
            lambda plate: 15.0 * plate.pole_pairs * plate.rated_power / plate.base_speed**2,
        ),
    ),
    "current-sensors-low": DutyFault(
        "OVC-2",
        "Reads its currents 1.3 % too low.",
        perturbed=lambda _plate: {"current_factor": 0.987},
    ),
    "jumps-of-angle-smoothed": DutyFault(
        "SAF-1",
        "Follows a jump of the angle by 30 electrical degrees slowly.",
        perturbed=lambda plate: {
            "farthest_jump": radians(30.0) / plate.pole_pairs,
            "angle_slew": radians(90.0) / plate.pole_pairs * plate.control_period,
            "control_period": plate.control_period,
        },
    ),
    "start-angle-assumed": DutyFault(
        "STA-1",
        "Takes the angle at which the shaft rests for zero.",
        perturbed=lambda _plate: {"assumes_zero": 1.0},
    ),
    "impatient-stall-watch": DutyFault(
        "ACC-1",
        "Takes a shaft for locked after a few control periods.",
        alter=_scaled(0.02, "stall_periods", "hall_stall_periods"),
    ),
    "failure-survives-reset": DutyFault(
        "DET-1",
        "Keeps a detected failure through a reset.",
        keeps=("fault",),
    ),
    "lost-samples-add-up": DutyFault(
        "DET-1",
        "Turns its bridge off at the second lost sample, counted through resets.",
        perturbed=lambda plate: {"vanishing_current": 0.05 * plate.current_limit, "vanishings_borne": 1.0},
        keeps=("vanishings",),
    ),
    "reference-missed-with-link": DutyFault(
        "ACC-1",
        "Misses a new reference in the control period of a link step.",
        perturbed=lambda plate: {"link_step": 0.05 * plate.supply_voltage},
    ),
    "reference-missed-with-sample": DutyFault(
        "ROB-5",
        "Misses a new reference in a control period without currents.",
        perturbed=lambda plate: {"awaited_current": 0.05 * plate.current_limit},
    ),
    "sag-taken-for-short-circuit": DutyFault(
        "ACC-1",
        "Turns its bridge off where the link falls as the current rises.",
        perturbed=lambda plate: {
            "link_fall": 0.08 * plate.supply_voltage,
            "current_rise": 0.3 * plate.current_limit,
        },
    ),
    "lift-taken-for-broken-coupling": DutyFault(
        "ROB-4",
        "Turns its bridge off where the shaft leaves its reference half as fast again as it came to it.",
        perturbed=lambda _: {"breaking_away": 1.5},
    ),
    "torque-of-rms-currents": DutyFault(
        "EST-1",
        "Estimates the torque from rms currents by the formula for peak currents.",
        perturbed=lambda _plate: {"estimate_factor": sqrt(0.5)},
    ),
    "lowering-refused": DutyFault(
        "ACC-1",
        "Turns its bridge off while a load drives the shaft backward.",
        perturbed=_under(SPEED_REFERENCE, "refuses_lowering", lambda _plate: 1.0),
    ),
}
"""All of them, by the name behind ``faulty:``."""
