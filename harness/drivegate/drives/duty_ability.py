"""What a PM AC drive can do over speed, whoever controls it: greatest torque, least current and least loss."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import Any, Final

import numpy as np

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.contracts.duty.best_operation import efficiency_map, known, trajectories
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.numbers import numbers
from drivegate.contracts.duty.scenarios.feasibility import IN_HAND, required_torque
from drivegate.contracts.duty.scenarios.windows import run_up_s
from drivegate.drives.ability import Ability, RunTime, rating_document
from drivegate.drives.constant_power import SPEEDS, ConstantPower
from drivegate.drives.link_ability import braking_points, link_facts, link_in_words
from drivegate.drives.power_reach import PowerReach
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.greatest_torque import greatest_within
from drivegate_models.machine.friction import friction_torque
from drivegate_models.pm_ac.fundamental import SIX_STEPS, SteadyState, base_speed
from drivegate_models.pm_ac.oracle import (
    CURRENT,
    LOSS,
    constant_power_end,
    least_at,
    undistorted_limits,
)
from drivegate_models.units import RADIANS_PER_RPM

BELOW_BASE: Final = 4
"""Steps of speed from standstill to base speed."""
CONSTANT_POWER: Final = 8
"""Steps from there to the highest."""
REACH_SPEEDS: Final = 13
"""Speeds from base speed to the highest at which rated power is looked for."""
LONGEST_RUN_UP_S: Final = 60.0
"""Longest time of a free shaft to its highest speed (s): runs are longer than that several times."""


def _greatest(document: PmAcDocument, speed: float) -> SteadyState:
    """Find the steady state of greatest torque at a speed (rad/s), with the field weakening that the drive states."""
    plant = document.plant()
    return greatest_within(plant, undistorted_limits(plant), speed, weakens=document.weakens)


def _constant_power_end(document: PmAcDocument) -> float:
    """Return the speed up to which rated power is maintained (rad/s): base speed at most without field weakening."""
    plant, rating = document.plant(), document.rating
    if document.weakens:
        return constant_power_end(plant, undistorted_limits(plant), rating.rated_power_w)
    base = rating.base_speed_rpm * RADIANS_PER_RPM
    return base if _greatest(document, base).torque * base >= rating.rated_power_w else 0.0


def _speeds(drive: DriveDocument) -> list[float]:
    rating = drive.rating
    parts = (
        np.linspace(0.0, rating.base_speed_rpm, BELOW_BASE + 1),
        np.linspace(rating.base_speed_rpm, rating.highest_speed_rpm, CONSTANT_POWER + 1)[1:],
        [rating.overspeed_rpm],
    )
    return list(dict.fromkeys(float(speed) for part in parts for speed in part))


def duty_envelope(drive: DriveDocument, report: Callable[[int], None] = lambda _: None) -> dict[str, Any]:
    """Compute what a drive can do, as plain data in people's units; None where something is out of reach."""
    document = duty_document(drive)
    plant = document.plant()
    limits = undistorted_limits(plant)
    begin, end = base_speed(plant, *limits), _constant_power_end(document)
    points = []
    for speed_rpm in _speeds(drive):
        points.append(_point(drive, speed_rpm))
        report(len(points))
    return {
        "rating": rating_document(drive),
        "control_period_s": document.inverter.control_period_s,
        "settling_s": limits_of(document).settling_s,
        "undistorted_voltage_v": limits.voltage,
        "six_step_voltage_v": SIX_STEPS * plant.link_voltage,
        "magnet_current_a": plant.magnet_flux / plant.direct_inductance,
        "voltage_used_up_at_rpm": begin / RADIANS_PER_RPM,
        "rated_power_up_to_rpm": end / RADIANS_PER_RPM if isfinite(end) else None,
        "points": points,
        "trajectories": trajectories(document),
        "efficiency_map": efficiency_map(document),
        **_link(document),
        **_start(document),
    }


def _link(document: PmAcDocument) -> dict[str, Any]:
    """Describe a link that is not ideal, under a key of its own."""
    speeds = [speed_rpm * RADIANS_PER_RPM for speed_rpm in _speeds(document)]
    facts = link_facts(document, speeds)
    return {"link": facts} if facts else {}


def _start(document: PmAcDocument) -> dict[str, Any]:
    """State what a drive without a position sensor must do at low speed."""
    if document.has_sensor:
        return {}
    return {"least_speed_rpm": document.least_speed_rpm, "start_time_s": document.start_time_s}


def _point(drive: DriveDocument, speed_rpm: float) -> dict[str, float | None]:
    document, rating = duty_document(drive), drive.rating
    plant, speed = document.plant(), speed_rpm * RADIANS_PER_RPM
    limits = undistorted_limits(plant)
    rated = rating.rated_power_w / (max(speed_rpm, rating.base_speed_rpm) * RADIANS_PER_RPM)
    most = _greatest(document, speed)
    least, cool = (least_at(plant, limits, speed, rated, purpose) for purpose in (CURRENT, LOSS))
    return {
        "speed_rpm": speed_rpm,
        "rated_torque_nm": rated,
        "greatest_torque_nm": known(most.torque),
        "greatest_power_w": known(most.torque * speed),
        "greatest_direct_a": known(most.direct),
        "greatest_quadrature_a": known(most.quadrature),
        "least_current_a": known(least.current),
        "direct_a": known(least.direct),
        "quadrature_a": known(least.quadrature),
        "voltage_v": known(least.voltage),
        "loss_w": known(least.loss),
        "least_loss_w": known(cool.loss),
        "least_loss_direct_a": known(cool.direct),
        **braking_points(document, speed),
    }


def _facts(document: dict[str, Any]) -> tuple[str, ...]:
    """Describe where the voltage is used up, how far rated power reaches, the times and the best efficiency."""
    limit, magnet = document["rating"]["current_limit_a"], document["magnet_current_a"]
    rating, end = document["rating"], document["rated_power_up_to_rpm"]
    reach = "at any speed" if end is None else f"up to {end:.5g} rpm"
    flux = f"{'within' if magnet <= limit else 'more than'} the limit of {limit:g} A"
    if rating["highest_speed_rpm"] == rating["base_speed_rpm"]:
        flux += ", but the drive is stated without field weakening"
    elif magnet <= limit:
        flux += ", so the speed range is unbounded"
    return (
        f"greatest undistorted phase voltage {document['undistorted_voltage_v']:.4g} V (peak), reached at the current "
        f"limit from {document['voltage_used_up_at_rpm']:.5g} rpm on; with six-step operation "
        f"{document['six_step_voltage_v']:.4g} V",
        f"characteristic current (magnet flux / d inductance) {magnet:.4g} A, {flux}; rated power is available {reach}",
        f"a step every {1e6 * document['control_period_s']:.4g} µs; a steady state is judged "
        f"{document['settling_s']:g} s after a change",
        _most_efficient(document["efficiency_map"]),
        *link_in_words(document.get("link", {})),
        *_without_sensor(document),
    )


def _without_sensor(document: dict[str, Any]) -> tuple[str, ...]:
    """State what a drive without a position sensor must do at low speed."""
    if "least_speed_rpm" not in document:
        return ()
    return (
        f"no position sensor: steady running from {document['least_speed_rpm']:.4g} rpm on, which is reached from "
        f"standstill within {document['start_time_s']:.3g} s under up to half of rated torque",
    )


def _most_efficient(charted: dict[str, Any]) -> str:
    rows = zip(charted["speed_rpm"], charted["torque_nm"], charted["efficiency_percent"], strict=True)
    places = [
        (value, speed, torque)
        for speed, *row in rows
        for torque, value in zip(*row, strict=True)
        if value is not None
    ]
    if not places:
        return "no torque of the efficiency map is within reach"
    value, speed, torque = max(places)
    return (
        f"best efficiency {value:.4g} % near {speed:.4g} rpm and {torque:.4g} N·m, at the currents of least loss; "
        "copper and core loss only"
    )


class _DutyAbility(Ability):
    speeds = staticmethod(_speeds)
    envelope = staticmethod(duty_envelope)
    facts = staticmethod(_facts)

    def run_time(self, drive: DriveDocument) -> RunTime:
        time = run_up_s(duty_document(drive), drive.rating.highest_speed_rpm)
        return RunTime(time, LONGEST_RUN_UP_S, "to its highest speed", LONGEST_RUN_UP_S / time)

    def reach(self, drive: DriveDocument) -> PowerReach:
        document, rating = duty_document(drive), drive.rating
        plant = document.plant()
        speeds = np.linspace(rating.base_speed_rpm, rating.highest_speed_rpm, REACH_SPEEDS) * RADIANS_PER_RPM
        if document.weakens:
            greatest = [IN_HAND * _greatest(document, float(speed)).torque for speed in speeds]
        else:
            greatest = [
                required_torque(document, plant, float(speed), plant.link_voltage) for speed in speeds
            ]
        return PowerReach(
            speeds=speeds,
            needed=rating.rated_power_w / speeds + friction_torque(plant, speeds),
            greatest=np.array([max(torque, 0.0) if isfinite(torque) else 0.0 for torque in greatest]),
            reserve=1.0 - IN_HAND,
        )

    def constant_power(self, drive: DriveDocument) -> ConstantPower:
        rating, document = drive.rating, duty_document(drive)
        first, last = (speed * RADIANS_PER_RPM for speed in (rating.base_speed_rpm, rating.overspeed_rpm))
        speeds = tuple(float(speed) for speed in np.linspace(first, last, SPEEDS))
        powers = tuple(float(_greatest(document, speed).torque * speed) for speed in speeds)
        end = _constant_power_end(document)
        return ConstantPower(speeds, powers, min(end, last) if powers[0] >= rating.rated_power_w else None)

    def required(self, drive: DriveDocument) -> tuple[str, ...]:
        weakening = (
            "in weakening at least {weakening} of the greatest torque with {weakening_voltage} of the voltage, "
            if duty_document(drive).weakens
            else ""
        )
        return (
            (
                "required: speed within {k1} (k1) or torque within {torque_error}, steps with at most {overshoot} of "
                f"overshoot and {{rise}}, {weakening}phase currents up to {{peak}}"
            ).format_map(numbers(drive, NOTHING_DECLARED)),
        )


DUTY_ABILITY: Final = _DutyAbility()
