"""Faulty controllers of duty ratios: field-oriented control with other constants, and the checks that catch them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import degrees, pi, radians, sqrt
from typing import Any, Final, TypeAlias

from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.fixed import turned_scenario
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.greatest_torque import greatest_within
from drivegate_cases.drive.pm_ac.link import PmAcLink
from drivegate_lab.candidates.faults.seeded_fault import NEEDS_ANGLE, FaultOnDrive, SeededFault
from drivegate_models.contract.duty.signals import SPEED_REFERENCE, TORQUE_REFERENCE, DutyNameplate
from drivegate_models.pm_ac.fundamental import steady_state
from drivegate_models.pm_ac.oracle import undistorted_limits
from drivegate_models.units import RADIANS_PER_RPM

STUCK_SHARE: Final = 0.3
"""Weakening that stays on, over the current limit (1)."""
_TRUE_HERE: Final = "the wrong value that the controller gets is right for this drive"
_LITTLE_TURN_DEG: Final = 3.5
"""Electrical angle of a control period at overspeed up to which current regulators make up for a wrong delay: measured,
FWK-3 is met at 2.98 degrees (pm-ac-hub) and fails at 3.96 (pm-ac-msl)."""
_PLACES: Final = 1000
"""Steps of the q current in which the torque of a weakened machine is looked for (1)."""
_LEFT_WEAKENING: Final = 0.3
"""Share of the weakening that a machine can use, which a controller with too little of it has (1)."""
_LITTLE_SALIENCY: Final = 1.5
"""Ratio of inductances up to which the wrong axis costs less current than MTP-1 allows (1)."""

_SUMMED_EDGES: Final = 4096
"""Edges a turn of the encoder whose edges are summed in single precision."""
_SINGLE_PRECISION: Final = 2**24
"""Whole numbers up to which single precision has every one."""
_NOTICED_FALL: Final = 0.08
"""Step of the source, over its voltage, at which a fall of the link is taken for a short circuit (1)."""
ENCODER_EDGES: Final = 10_000
"""Edges a turn of the encoder whose counter is too short; 16 bits are no whole number of its turns."""

Amount: TypeAlias = float | Callable[[DutyNameplate], float]
"""A number, or what it follows from on a drive."""


@dataclass(frozen=True)
class DutyFault(SeededFault):
    """A fault that is made by changing the controller's nameplate or its state, or its senses and answers."""

    base: str = "foc"
    believes: Mapping[str, Amount] = field(default_factory=dict)
    """Wrong numbers in the nameplate that the controller is given."""
    alter: Callable[[Any], None] | None = None
    """Changes the record of the state, just reset, otherwise than by factors."""
    changes: Mapping[str, Amount] = field(default_factory=dict)
    """Changed fields of `PERTURBED_STATE`."""
    under: int | None = None
    """The one kind of reference under which they are changed; None for all."""
    harmless: Callable[[PmAcDocument], str | None] | None = None
    """States why the fault costs nothing on a drive, None where it does."""
    source: str | None = None
    """The source of the link that the fault shows with, "battery", or "rectifier" without a chopper; None for any."""
    less_salient: tuple[float, str] | None = None
    """Ratio of the inductances across the magnet's axis and along it up to which another check must catch it,
    and that check: the less reluctance torque there is, the less torque and current a wrong angle or
    inductance costs."""

    def believed(self, plate: DutyNameplate) -> DutyNameplate:
        """Return the nameplate that the controller is given for the true one."""
        return plate._replace(**_amounts(self.believes, plate))

    def changed(self, plate: DutyNameplate) -> dict[str, float]:
        """Return the changed fields of `PERTURBED_STATE` for a nameplate."""
        return _amounts(self.changes, plate) if self.under in (None, plate.reference_kind) else {}

    def check_on(self, drive: DriveDocument) -> str:
        """Return the identifier of the check that must catch it, by the drive's saliency."""
        plate = _nameplate(drive)
        ratio = plate.quadrature_inductance / plate.direct_inductance
        return (
            self.check if self.less_salient is None or ratio > self.less_salient[0] else self.less_salient[1]
        )

    def on(self, drive: DriveDocument) -> FaultOnDrive:
        """Return what the fault is on a drive; it idles where its check, or its wrong number, does."""
        plate, named = _nameplate(drive), self.check_on(drive)
        if drive.position == "none":
            return FaultOnDrive(named, self.sentence, "", NEEDS_ANGLE)
        # A drive without dead time is also run with some, which is on the nameplate then.
        blanked = plate._replace(dead_time=plate.dead_time or plate.control_period)
        if self.believes and self.believed(blanked) == blanked:
            return FaultOnDrive(named, self.sentence, "", _TRUE_HERE)
        link = duty_document(drive).real_link
        if self.source is not None and (link is None or _source_of(link) != self.source):
            return FaultOnDrive(named, self.sentence, "", f"it shows on a link with a {self.source}")
        check = next(check for check in contract_of(drive).checks if check.id == named)
        reason = check.reason_not_applicable(resolve_candidate(self.base).declaration, drive)
        if reason is None and self.harmless is not None:
            reason = self.harmless(duty_document(drive))
        return FaultOnDrive(named, self.sentence, "", reason)


def _source_of(link: PmAcLink) -> str:
    return "chopper" if link.chopper_on_v is not None else link.source


def _nameplate(drive: DriveDocument) -> DutyNameplate:
    document = duty_document(drive)
    return document.duty_nameplate(document.control_period_s, torque_reference=True)


def _amounts(of: Mapping[str, Amount], plate: DutyNameplate) -> dict[str, Any]:
    return {name: amount(plate) if callable(amount) else amount for name, amount in of.items()}


# Each of these makes a fault of one kind; its name is its key in the table of all.
def _wrong_number(
    check: str, sentence: str, less_salient: tuple[float, str] | None = None, **believes: Amount
) -> DutyFault:
    kind = "Wrong numbers of the drive"
    return DutyFault("", sentence, check, kind=kind, less_salient=less_salient, believes=believes)


def _regulation(
    check: str, sentence: str, alter: Callable[[Any], None] | None = None, **factors: float
) -> DutyFault:
    return DutyFault("", sentence, check, kind="Regulation", alter=alter, factors=tuple(factors.items()))


def _turns_little(drive: PmAcDocument) -> str | None:
    """State that voltages of a wrong delay are hardly off on a drive."""
    speed = drive.machine.pole_pairs * drive.rating.overspeed_rpm * RADIANS_PER_RPM
    turned = degrees(speed * drive.control_period_s)
    if turned > _LITTLE_TURN_DEG:
        return None
    return f"the rotor turns by {turned:.2g} degrees at most in a control period, for which its regulators make up"


def _weakens_enough(drive: PmAcDocument) -> str | None:
    """State that the weakening that is left suffices for the torque that a drive must have at its highest speed."""
    plant, limits = drive.plant(), limits_of(drive)
    voltage = undistorted_limits(plant, limits.weakening_voltage * plant.link_voltage)
    speed = drive.rating.highest_speed_rpm * RADIANS_PER_RPM
    greatest = greatest_within(plant, voltage, speed, weakens=True)
    deepest = -_LEFT_WEAKENING * min(plant.current_limit, plant.magnet_flux / plant.direct_inductance)
    if greatest.direct < deepest:
        # The greatest torque within both limits at the deepest d current that is left.
        across = sqrt(max(plant.current_limit * plant.current_limit - deepest * deepest, 0.0))
        states = (steady_state(plant, speed, deepest, across * k / _PLACES) for k in range(_PLACES + 1))
        left = max((each.torque for each in states if each.voltage <= voltage.voltage), default=0.0)
        if left < limits.weakening * greatest.torque:
            return None
    return "the drive needs no more weakening than the fault leaves"


def _turns_few_edges(drive: PmAcDocument) -> str | None:
    """State that single precision still counts every edge of the turns before a run."""
    turns = turned_scenario(drive).turns_before
    if turns * _SUMMED_EDGES > _SINGLE_PRECISION:
        return None
    return f"single precision counts each edge of the {turns:.4g} turns before a run; nightly has a million turns"


def _falls_slowly(drive: PmAcDocument) -> str | None:
    """State that only the bridge lowers the link's voltage, and too slowly to notice."""
    plate, link = _nameplate(drive), drive.real_link
    if link is None or link.source == "battery":
        return None
    fall = _most_current(plate) * plate.control_period / plate.link_capacitance
    if fall > _seen_at_once(plate, _NOTICED_FALL):
        return None
    return f"the bridge lowers the rectifier's link by {fall:.2g} V at most in a control period"


def _signals(
    check: str,
    sentence: str,
    under: int | None = None,
    less_salient: tuple[float, str] | None = None,
    **changes: Amount,
) -> DutyFault:
    kind = "Senses and answers"
    return DutyFault("", sentence, check, kind=kind, under=under, less_salient=less_salient, changes=changes)


def _kept(check: str, sentence: str, keeps: tuple[str, ...], **changes: Amount) -> DutyFault:
    return DutyFault("", sentence, check, kind="Instances and resets", keeps=keeps, changes=changes)


def _weakens_little(state: Any) -> None:
    """Allow a share of the weakening that a machine can use: more than that costs it little torque."""
    state["deepest"] = _LEFT_WEAKENING * max(
        state["deepest"], -state["magnet_flux"] / state["direct_inductance"]
    )


def _rise(plate: DutyNameplate) -> float:
    """Return the permitted rise of the windings' temperature (K)."""
    return plate.temperature_limit - plate.ambient_temperature


def _hotter(share: float) -> Callable[[DutyNameplate], float]:
    """Return a temperature limit that is off by a share of the permitted rise."""
    return lambda plate: plate.temperature_limit + share * _rise(plate)


def _continuous_torque(plate: DutyNameplate) -> float:
    """Return the magnet's torque of the q current alone that the windings bear for good (N m)."""
    if plate.heat_capacity == 0.0:
        return 0.0
    hot = plate.resistance * (1.0 + plate.temperature_coefficient * _rise(plate))
    current = sqrt(_rise(plate) / (plate.thermal_resistance * 1.5 * hot))
    return 1.5 * plate.pole_pairs * plate.magnet_flux * current


def _links(
    check: str,
    sentence: str,
    source: str | None = None,
    alter: Callable[[Any], None] | None = None,
    **believes: Amount,
) -> DutyFault:
    return DutyFault("", sentence, check, kind="DC link", source=source, alter=alter, believes=believes)


def _most_current(plate: DutyNameplate) -> float:
    """Return the current that the current limit takes from the source at base speed (A)."""
    torque = 1.5 * plate.pole_pairs * plate.magnet_flux * plate.current_limit
    loss = 1.5 * plate.resistance * plate.current_limit**2
    return (torque * plate.base_speed + loss) / plate.supply_voltage


def _discharges_more(plate: DutyNameplate) -> float:
    """Return three times the limit of discharging, where the current limit takes that much."""
    limit = plate.discharge_limit
    return 3.0 * limit if _most_current(plate) > 1.2 * limit else limit


def _burns_more(plate: DutyNameplate) -> float:
    """Return a third of the chopper's resistance, where the shaft can supply more than it burns."""
    resistance = plate.chopper_resistance
    if resistance == 0.0:
        return resistance
    shaft = 1.5 * plate.pole_pairs * plate.magnet_flux * plate.current_limit * plate.base_speed
    is_saturated = shaft > 1.5 * plate.chopper_voltage**2 / resistance
    return resistance / 3.0 if is_saturated else resistance


def _above_nominal(plate: DutyNameplate, share: float) -> float:
    """Return a voltage between the nominal one of the link and its limit (V)."""
    return plate.supply_voltage + share * (plate.link_limit - plate.supply_voltage)


def _seen_at_once(plate: DutyNameplate, share: float) -> float:
    """Return how far the link follows a step of its source by a share of it within a control period (V)."""
    period, charging = plate.control_period, plate.source_resistance * plate.link_capacitance
    return share * plate.supply_voltage * period / (period + charging)


def _charges_nervously(state: Any) -> None:
    state["charging_gain"] *= 60.0


def _derates(
    check: str, sentence: str, alter: Callable[[Any], None] | None = None, **believes: Amount
) -> DutyFault:
    kind = "Temperature of the windings"
    return DutyFault("", sentence, check, kind=kind, alter=alter, believes=believes)


def _cuts(check: str, sentence: str, **changes: Amount) -> DutyFault:
    """Make a fault that limits the torque in place of the current."""
    kind = "Temperature of the windings"
    return DutyFault("", sentence, check, kind=kind, believes={"heat_capacity": 0.0}, changes=changes)


def _approaches_at_once(state: Any) -> None:
    state["approach"] = 0.001


def _pole_pairs(plate: DutyNameplate) -> float:
    return float(plate.pole_pairs)


def _control_period(plate: DutyNameplate) -> float:
    return plate.control_period


def _idle_torque(plate: DutyNameplate) -> float:
    """Return the torque by which idling is noticed, under a speed reference alone (N m)."""
    return 1.6 * plate.rated_power / plate.base_speed if plate.reference_kind == SPEED_REFERENCE else 0.0


_UNNAMED: Final = {
    "stuck-weakening": _signals(
        "FWK-2",
        "Weakens by 30 % of the current limit at all times.",
        direct_added=lambda plate: STUCK_SHARE * plate.current_limit,
        pole_pairs=_pole_pairs,
    ),
    "delay-turned-back": replace(
        _regulation(
            "FWK-3", "Turns its voltages back by the angle of the delay instead of ahead.", lead=-1.0
        ),
        harmless=_turns_little,
    ),
    "wrong-pole-pairs": _wrong_number(
        "ACC-1", "Counts one pole pair too many.", pole_pairs=lambda plate: plate.pole_pairs + 1
    ),
    "generous-current-limit": _wrong_number(
        "OVC-1",
        "Takes a current limit that is 40 % too high.",
        current_limit=lambda plate: 1.4 * plate.current_limit,
    ),
    "lenient-current-limit": _wrong_number(
        "OVC-2",
        "Takes a current limit that is 10 % too high.",
        current_limit=lambda plate: 1.1 * plate.current_limit,
    ),
    "weak-magnets-assumed": _wrong_number(
        "ACC-1",
        "Converts torque to current with 80 % of the magnet's flux.",
        magnet_flux=lambda plate: 0.8 * plate.magnet_flux,
    ),
    "saliency-ignored": _wrong_number(
        "MTP-1",
        "Takes the inductance of the magnet's axis for both axes.",
        less_salient=(_LITTLE_SALIENCY, "FWK-2"),
        quadrature_inductance=lambda plate: plate.direct_inductance,
    ),
    "no-speed-integral": _regulation(
        "ACC-1", "Regulates the speed by its error alone.", speed_integral_step=0.0
    ),
    "slow-currents": _regulation(
        "STP-1",
        "Regulates its currents with a sixth of the gain.",
        direct_gain=1.0 / 6.0,
        quadrature_gain=1.0 / 6.0,
        direct_integral_step=1.0 / 6.0,
        quadrature_integral_step=1.0 / 6.0,
    ),
    "nervous-currents": _regulation(
        "STP-1", "Regulates its currents with three times the gain.", direct_gain=3.0, quadrature_gain=3.0
    ),
    "angle-offset": _signals(
        "ACC-1",
        "Has an angle that is 5 electrical degrees off.",
        less_salient=(1.0, "FWK-2"),
        angle_added=lambda plate: radians(5.0) / plate.pole_pairs,
    ),
    "current-sensor-offset": _signals(
        "ACC-1",
        "Reads the first phase current 15 % of the current limit too high.",
        current_added=lambda plate: 0.15 * plate.current_limit,
    ),
    "current-sensor-gain": _signals("ACC-1", "Reads its currents 10 % too high.", current_factor=1.1),
    "speed-misread": _signals("ACC-1", "Reads the speed 3 % too high.", speed_factor=1.03),
    "supply-underestimated": _signals(
        "FWK-1", "Takes the link for 20 % less than it has, and weakens too early.", supply_factor=0.8
    ),
    "late-samples": replace(
        _signals("FWK-3", "Regulates with the currents of the step before.", is_late=1.0),
        harmless=_turns_little,
        less_salient=(1.0, "FWK-2"),
    ),
    "unclamped-ratios": _signals(
        "DUT-1", "Stretches its duty ratios by a fifth after its limiter.", stretch=1.2
    ),
    "swapped-phases": _signals(
        "ACC-1", "Drives the third phase with the second one's ratio.", swaps_phases=1.0
    ),
    "long-period": _signals(
        "DUT-1",
        "Asks for a control period that is half as long again.",
        next_period=lambda plate: 1.5 * plate.control_period,
    ),
    "swapped-axes": _wrong_number(
        "MTP-1",
        "Swaps the inductances of the axes.",
        less_salient=(_LITTLE_SALIENCY, "FWK-2"),
        direct_inductance=lambda plate: plate.quadrature_inductance,
        quadrature_inductance=lambda plate: plate.direct_inductance,
    ),
    "reversed-currents": _signals("OVC-1", "Reads its currents with the wrong sign.", current_factor=-1.0),
    "eager-integrals": _regulation(
        "STP-1",
        "Regulates its currents with ten times the integral gain.",
        direct_integral_step=10.0,
        quadrature_integral_step=10.0,
    ),
    "shy-current-limit": _wrong_number(
        "FWK-1",
        "Takes a current limit that is 30 % too low.",
        current_limit=lambda plate: 0.7 * plate.current_limit,
    ),
    "strong-magnets-assumed": _wrong_number(
        "FWK-2",
        "Counts on 30 % more of the magnet's flux, and weakens where the voltage is free.",
        less_salient=(1.0, "ACC-1"),
        magnet_flux=lambda plate: 1.3 * plate.magnet_flux,
    ),
    "resistance-overestimated": _wrong_number(
        "FWK-1",
        "Takes five times the resistance, and leaves voltage unused for it.",
        resistance=lambda plate: 5.0 * plate.resistance,
    ),
    "direct-inductance-doubled": _wrong_number(
        "ACC-1",
        "Takes twice the inductance of the magnet's axis.",
        (1.0, "FWK-2"),
        direct_inductance=lambda plate: 2.0 * plate.direct_inductance,
    ),
    "slow-torque": _regulation(
        "ACC-1", "Lets its torque follow the speed regulator at a hundredth of the rate.", torque_step=0.01
    ),
    "field-strengthened": _signals(
        "FWK-2",
        "Strengthens the field by 10 % of the current limit.",
        direct_added=lambda plate: -0.1 * plate.current_limit,
        pole_pairs=_pole_pairs,
    ),
    "shallow-weakening": replace(
        _regulation(
            "FWK-1",
            "Weakens by at most 30 % of what cancels the magnet's flux, or of the current limit.",
            alter=_weakens_little,
        ),
        harmless=_weakens_enough,
    ),
    "delay-overcompensated": _regulation(
        "DEC-1", "Turns its voltages ahead by six times the delay.", lead=6.0
    ),
    "shrunken-ratios": _signals("FWK-1", "Gives 85 % of the voltage that it counts on.", stretch=0.85),
    "third-current-computed": _signals(
        "SAF-1",
        "Computes the third current from the other two, and so misses a stuck sensor.",
        computes_third=1.0,
    ),
    "dead-time-times-ten": _wrong_number(
        "DTM-1", "Makes up for ten times the dead time.", dead_time=lambda plate: 10.0 * plate.dead_time
    ),
    "small-current-offset": _signals(
        "RIP-4",
        "Reads the first phase current 3 % of the current limit too high.",
        current_added=lambda plate: 0.03 * plate.current_limit,
    ),
    "clamped-phases": _signals(
        "STP-1",
        "Takes the link's voltage for half, and clamps each phase's duty ratio by itself.",
        stretch=2.0,
        clamps=1.0,
    ),
    "swapped-hall-switches": _signals(
        "ACC-1", "Has two Hall switches swapped, so that its angle turns backward.", angle_factor=-1.0
    ),
    "short-encoder-counter": _signals(
        "ACC-1",
        "Counts an encoder of 10,000 edges a turn in 16 bits.",
        wraps_after=2.0 * pi * 2**16 / ENCODER_EDGES,
    ),
    "patient-stall-watch": _regulation(
        "SAF-1",
        "Takes a standing shaft for locked only after four seconds under the greatest torque.",
        stall_periods=100,
        hall_stall_periods=100,
    ),
    "hall-edges-counted": _signals(
        "SAF-1", "Counts Hall edges instead of reading states.", counts_edges=1.0, pole_pairs=_pole_pairs
    ),
    "weak-braking": _signals(
        "ACC-1",
        "Limits a braking torque to 60 % of rated torque at base speed.",
        under=TORQUE_REFERENCE,
        backward_limit=lambda plate: 0.6 * plate.rated_power / plate.base_speed,
    ),
    "braking-cut-off": _signals(
        "ACC-1",
        "Refuses to brake above 105 % of the nominal link voltage.",
        under=TORQUE_REFERENCE,
        braking_voltage=lambda plate: 1.05 * plate.supply_voltage,
    ),
    "slow-shaft-unseen": _signals(
        "ACC-1",
        "Takes the shaft for standing below 4 % of base speed.",
        under=SPEED_REFERENCE,
        least_speed=lambda plate: 0.04 * plate.base_speed,
    ),
    "idle-speed-forced": _signals(
        "ACC-1",
        "Raises a speed reference below 6 % of base speed to that speed.",
        under=SPEED_REFERENCE,
        least_reference=lambda plate: 0.06 * plate.base_speed,
    ),
    "light-rotor-assumed": _regulation(
        "ROB-4", "Regulates the speed with a quarter of the gain, as for a lighter rotor.", speed_gain=0.25
    ),
    "heavy-rotor-assumed": _regulation(
        "ROB-4",
        "Regulates the speed with twelve times the gains, as for a heavier rotor.",
        speed_gain=12.0,
        speed_integral_step=12.0,
    ),
    "backward-refused": _signals(
        "ACC-1", "Takes a speed reference backward for standstill.", under=SPEED_REFERENCE, backward_limit=0.0
    ),
    "one-way-prediction": _signals(
        "SYM-1",
        "Predicts the angle for the delay of its voltages by the magnitude of the speed.",
        under=TORQUE_REFERENCE,
        ahead=lambda plate: (plate.update_delay + 0.5) * plate.control_period,
    ),
    "microseconds-signed": _signals(
        "ACC-1",
        "Ramps its reference up by a signed clock of microseconds, negative after 36 minutes.",
        ramp=lambda plate: 100.0 * plate.control_period,
    ),
    "offsets-under-current": _signals(
        "RIP-4",
        "Takes the first currents below base speed for offsets, also after a restart.",
        calibrates_below=lambda plate: plate.base_speed,
    ),
    "undervoltage-at-once": _signals(
        "ROB-5",
        "Turns its bridge off at one sample of less than half the link voltage.",
        least_voltage=lambda plate: 0.5 * plate.supply_voltage,
    ),
    "jump-of-angle-believed": _regulation(
        "SAF-1", "Does not notice the jump of the angle by a magnet that slips.", farthest_drift=1000.0
    ),
    "hall-edge-awaited": _regulation(
        "SAF-1", "Holds its angle at the sector's end where a Hall edge is missing.", led_on_longest=0.0
    ),
    "braking-reserve": _signals(
        "FWK-2",
        "Plans braking currents with 20 % less of the link than there is.",
        under=TORQUE_REFERENCE,
        braking_supply_factor=0.8,
    ),
    "overvoltage-ends-braking": _signals(
        "ACC-1",
        "Turns its bridge off above 112 % of the link's voltage while it brakes.",
        under=TORQUE_REFERENCE,
        highest_voltage=lambda plate: 1.12 * plate.supply_voltage,
    ),
    "weakening-kept-near-base": _signals(
        "FWK-2",
        "Weakens from 97 % of base speed on, and in part down to 90 %.",
        weakens_from=lambda plate: 0.97 * plate.base_speed,
        weakens_until=lambda plate: 0.9 * plate.base_speed,
        weakened_by=lambda plate: 0.25 * plate.current_limit,
        pole_pairs=_pole_pairs,
    ),
    "offsets-after-idling": _signals(
        "RIP-4",
        "Takes its currents for offsets after the load has vanished, also once it is back.",
        idle_torque=_idle_torque,
        idle_noticed=400.0,
        idle_calibrated=1300.0,
        is_calibrated=1.0,
        calibrates_below=lambda plate: plate.base_speed,
    ),
    "reference-clipped": _signals(
        "ACC-1",
        "Limits a speed reference to the highest speed.",
        under=SPEED_REFERENCE,
        most_reference=lambda plate: plate.highest_speed,
    ),
    "speed-clipped": _signals(
        "ACC-1",
        "Reads no speed above 104 % of the highest.",
        most_speed=lambda plate: 1.04 * plate.highest_speed,
    ),
    "lost-currents-trip": _signals(
        "ROB-5",
        "Turns its bridge off at one sample without currents.",
        vanishing_current=lambda plate: 0.05 * plate.current_limit,
    ),
    "false-edges-trip": _signals(
        "ROB-5",
        "Turns its bridge off where the angle jumps by 2 electrical degrees.",
        farthest_jump=lambda plate: radians(2.0) / plate.pole_pairs,
        trips_at_jump=1.0,
        control_period=_control_period,
    ),
    "phase-after-false-edges": _signals(
        "ROB-5",
        "Adds 120 electrical degrees where the angle jumps by 2.",
        farthest_jump=lambda plate: radians(2.0) / plate.pole_pairs,
        jump_taken_for=lambda plate: radians(120.0) / plate.pole_pairs,
        control_period=_control_period,
    ),
    "swinging-speed-trips": _signals(
        "ROB-5",
        "Turns its bridge off where the speed swings within a turn.",
        loose_swing=lambda plate: 0.03 / plate.pole_pairs,
        swings=24.0,
        control_period=_control_period,
    ),
    "swings-damped-one-way": _signals(
        "ROB-5",
        "Damps swings of the speed, but only takes torque.",
        under=TORQUE_REFERENCE,
        damping=lambda plate: 15.0 * plate.pole_pairs * plate.rated_power / plate.base_speed**2,
    ),
    "current-sensors-low": _signals("OVC-2", "Reads its currents 1.3 % too low.", current_factor=0.987),
    "jumps-of-angle-smoothed": _signals(
        "SAF-1",
        "Follows a jump of the angle by 30 electrical degrees slowly.",
        farthest_jump=lambda plate: radians(30.0) / plate.pole_pairs,
        angle_slew=lambda plate: radians(90.0) / plate.pole_pairs * plate.control_period,
        control_period=_control_period,
    ),
    "start-angle-assumed": _signals(
        "STA-1", "Takes the angle at which the shaft rests for zero.", assumes_zero=1.0
    ),
    "impatient-stall-watch": _regulation(
        "ACC-1",
        "Takes a shaft for locked after a few control periods.",
        stall_periods=0.02,
        hall_stall_periods=0.02,
    ),
    "failure-survives-reset": _kept("DET-1", "Keeps a detected failure through a reset.", keeps=("fault",)),
    "lost-samples-add-up": _kept(
        "DET-1",
        "Turns its bridge off at the second lost sample, counted through resets.",
        keeps=("vanishings",),
        vanishing_current=lambda plate: 0.05 * plate.current_limit,
        vanishings_borne=1.0,
    ),
    "reference-missed-with-link": _signals(
        "ACC-1",
        "Misses a new reference in the control period of a link step.",
        link_step=lambda plate: _seen_at_once(plate, 0.05),
    ),
    "reference-missed-with-sample": _signals(
        "ROB-5",
        "Misses a new reference in a control period without currents.",
        awaited_current=lambda plate: 0.05 * plate.current_limit,
    ),
    "sag-taken-for-short-circuit": replace(
        _signals(
            "ACC-1",
            "Turns its bridge off where the link falls as the current rises.",
            link_fall=lambda plate: _seen_at_once(plate, _NOTICED_FALL),
            current_rise=lambda plate: 0.3 * plate.current_limit,
        ),
        harmless=_falls_slowly,
    ),
    "lift-taken-for-broken-coupling": _signals(
        "ROB-4",
        "Turns its bridge off where the shaft leaves its reference half as fast again as it came to it.",
        breaking_away=1.5,
    ),
    "torque-of-rms-currents": _signals(
        "EST-1",
        "Estimates the torque from rms currents by the formula for peak currents.",
        estimate_factor=sqrt(0.5),
    ),
    "lowering-refused": _signals(
        "ACC-1",
        "Turns its bridge off while a load drives the shaft backward.",
        under=SPEED_REFERENCE,
        refuses_lowering=1.0,
    ),
    "braking-ends-at-highest-speed": _signals(
        "ACC-1",
        "Gives no torque against the rotation above 102 % of the highest speed.",
        under=TORQUE_REFERENCE,
        braking_until=lambda plate: 1.02 * plate.highest_speed,
    ),
    "overspeed-taken-early": _signals(
        "ACC-1",
        "Turns its bridge off above 109 % of the highest speed.",
        trips_from=lambda plate: 1.09 * plate.highest_speed,
    ),
    "speed-taken-for-constant": replace(
        _signals(
            "ACC-1",
            "Takes the speed at the last change of the torque reference for the present one.",
            under=TORQUE_REFERENCE,
            keeps_speed=1.0,
        ),
        harmless=_turns_little,
    ),
    "torque-ramped-after-stall": _signals(
        "ACC-1",
        "Ramps its torque up again where a shaft that stood under it begins to turn.",
        under=TORQUE_REFERENCE,
        standing=lambda plate: 0.005 * plate.base_speed,
        stalled_after=1000.0,
        ramped_within=10_000.0,
    ),
    "turns-summed-in-single-precision": _signals(
        "ACC-1",
        "Sums its commutation angle over all turns in single precision.",
        summed_step=lambda plate: radians(0.1) / plate.pole_pairs,
    ),
    "edges-summed-in-single-precision": replace(
        _signals(
            "ACC-1",
            "Sums all edges of an encoder in single precision.",
            summed_step=2.0 * pi / _SUMMED_EDGES,
        ),
        harmless=_turns_few_edges,
    ),
    "link-limit-overestimated": _links(
        "LNK-1",
        "Takes a limit of the link that is a fifth too high.",
        "rectifier",
        link_limit=lambda plate: 1.2 * plate.link_limit,
    ),
    "rectifier-taken-for-battery": _links(
        "LNK-1",
        "Takes a rectifier for a battery that may be charged.",
        "rectifier",
        link_limit=lambda plate: 10.0 * plate.link_limit,
        charge_limit=lambda plate: plate.discharge_limit,
    ),
    "link-taken-for-ideal": _links(
        "LNK-1", "Brakes as if the link were ideal.", "rectifier", link_capacitance=0.0
    ),
    "charging-unlimited": _links(
        "LNK-2",
        "Takes three times the current that the battery may be charged with.",
        "battery",
        charge_limit=lambda plate: 3.0 * plate.charge_limit,
    ),
    "discharging-unlimited": _links(
        "LNK-2",
        "Takes three times the current that the source may supply.",
        discharge_limit=_discharges_more,
    ),
    "battery-charged-shyly": _links(
        "LNK-3",
        "Charges the battery with a third of what it takes, and brakes as little.",
        "battery",
        charge_limit=lambda plate: plate.charge_limit / 3.0,
    ),
    "chopper-overestimated": _links(
        "LNK-1",
        "Counts on a chopper that burns three times the power.",
        chopper_resistance=_burns_more,
    ),
    "link-regulated-nervously": _links(
        "LNK-3",
        "Regulates the link while braking with sixty times the gain.",
        "rectifier",
        alter=_charges_nervously,
    ),
    "charging-limited-as-discharging": _links(
        "LNK-2",
        "Takes the limit of discharging for that of charging.",
        "battery",
        charge_limit=lambda plate: plate.discharge_limit,
    ),
    "braking-burnt-in-bursts": DutyFault(
        "",
        "Burns the energy of braking by turning d current on and off at two voltages of the link.",
        "LNK-4",
        kind="DC link",
        source="rectifier",
        changes={
            "bursts_from": lambda plate: _above_nominal(plate, 0.5),
            "bursts_until": lambda plate: _above_nominal(plate, 0.25),
            "burst_current": lambda plate: 0.6 * plate.current_limit,
            "bursts_within": lambda plate: plate.current_limit,
            "pole_pairs": _pole_pairs,
        },
    ),
    "temperature-limit-raised": _derates(
        "THM-1",
        "Takes a temperature limit that is a quarter of the permitted rise too high.",
        temperature_limit=_hotter(0.25),
    ),
    "temperature-read-low": DutyFault(
        "",
        "Reads the temperature of its windings a fifth of the permitted rise too low.",
        "THM-1",
        kind="Temperature of the windings",
        changes={"temperature_added": lambda plate: -0.2 * _rise(plate)},
    ),
    "torque-alone-derated": _cuts(
        "THM-2",
        "Limits the q current of hot windings alone, and leaves them the current of weakening.",
        cut_from=_hotter(-0.1),
        cut_until=_hotter(-0.1),
        cut_torque=_continuous_torque,
    ),
    "derated-while-cool": _derates(
        "THM-3", "Derates from 60 % of the permitted rise on.", temperature_limit=_hotter(-0.4)
    ),
    "derated-at-once": _derates(
        "THM-3", "Takes the whole excess of the current at once at the limit.", alter=_approaches_at_once
    ),
    "torque-off-until-cool": _cuts(
        "THM-3",
        "Turns the torque off at 96 % of the permitted rise, until 5 % of it have gone.",
        cut_from=_hotter(-0.04),
        cut_until=_hotter(-0.09),
        cut_torque=0.0,
    ),
}

DUTY_FAULTS: Final = {name: replace(fault, name=name) for name, fault in _UNNAMED.items()}
"""All of them, by the name behind ``faulty:``."""
