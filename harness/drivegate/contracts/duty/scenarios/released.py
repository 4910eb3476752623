"""Runs in which a shaft that did not turn freely begins to: released by its dynamometer, or after a stall."""

from __future__ import annotations

import math
from typing import Final

from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.building import dwell_periods, speed_scenario, start_s, torque_of
from drivegate.contracts.duty.scenarios.windows import duty_dwells, settling_s, shaft_inertia
from drivegate.scenarios.changes import in_steps
from drivegate.scenarios.drive_scale import rated_torque_at, tidy
from drivegate.scenarios.title import titled
from drivegate_cases.drive.limits import rounded
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.courses import Drift
from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_cases.scenario.profile import released_s
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.machine.friction import friction_torque
from drivegate_models.units import RADIANS_PER_RPM

GREATEST_FREE_SHARE: Final = 0.5
"""Greatest torque that turns a released shaft, over rated torque (1)."""
FREE_SHARE: Final = 0.5
"""Least time in which a released shaft changes its speed, over the settling time of a torque (1)."""
UNCERTAIN: Final = 0.05
"""Share by which the torque on a released shaft may differ from its reference (1)."""
STALL_SHARE: Final = 0.25
"""Length of a stall over the settling time of the speed (1)."""
STALLING_SHARE: Final = 9.0
"""Friction that stalls a shaft over the rated torque at base speed, which no drive overcomes (1)."""


def released_scenario(drive: PmAcDocument, held_rpm: float, end_rpm: float) -> Scenario:
    """Make a run whose shaft is held at a speed, and is then turned freely to another by the same torque."""
    way = (end_rpm - held_rpm) * RADIANS_PER_RPM
    inertia, friction = drive.machine.inertia_kg_m2, float(friction_torque(drive.plant(), abs(way)))
    most = GREATEST_FREE_SHARE * rated_torque_at(drive, max(abs(held_rpm), abs(end_rpm)))
    time = FREE_SHARE * settling_s(drive, held=True)
    size = min(inertia * abs(way) / time + friction, most)
    torque = rounded(math.copysign(size, way), 3)
    periods = dwell_periods(drive, held=True)
    released = start_s(drive, periods)
    free = (
        int(inertia * abs(way) / (size - friction) / drive.control_period_s) if size > friction else periods
    )
    return titled(
        Scenario(
            name="released",
            drive=drive,
            duration_s=start_s(drive, periods + free),
            initial_speed_rpm=held_rpm,
            speed_rpm=((0.0, held_rpm),),
            load=DynamometerLoad(
                kind="dynamometer", torque_reference_nm=((0.0, torque),), released_s=released
            ),
        )
    )


def stalled_scenario(drive: PmAcDocument, speed_rpm: float, share: float) -> Scenario:
    """Make a run whose shaft does not start for a while, as if it were locked, and then comes free under a load."""
    run = speed_scenario(
        drive, (speed_rpm,), torque_nm=torque_of(drive, speed_rpm, share), initial_speed_rpm=0.0
    )
    periods = math.ceil(STALL_SHARE * settling_s(drive, held=False) / drive.control_period_s)
    stalling = tidy(STALLING_SHARE * drive.rating.rated_torque_nm)
    friction = in_steps((stalling, 0.0), (start_s(drive, periods),))
    end = start_s(drive, periods + round(run.duration_s / drive.control_period_s))
    return titled(run.replaced(duration_s=end, drift=Drift(friction_n_m=friction)))


def free_shaft_scenarios(drive: PmAcDocument) -> list[Scenario]:
    """Make the fixed runs: from standstill, into weakening, and after a stall under a speed reference."""
    rating = drive.rating
    base, highest = rating.base_speed_rpm, rating.highest_speed_rpm
    return [
        released_scenario(drive, 0.0, tidy(0.9 * base)),
        released_scenario(drive, tidy(0.6 * base), tidy(0.95 * highest)),
        stalled_scenario(drive, tidy(0.3 * base), 0.3),
    ]


def unfair_release(scenario: Scenario) -> str | None:
    """State why a released shaft goes where no controller may be judged."""
    released = released_s(scenario)
    if released is None:
        return None
    drive = duty_document(scenario.drive)
    slowest = fastest = scenario.speed_rpm[-1][1] * RADIANS_PER_RPM
    highest = drive.rating.highest_speed_rpm * RADIANS_PER_RPM
    for dwell in duty_dwells(scenario):
        if dwell.start < released:
            continue
        inertia = shaft_inertia(scenario, dwell.scales)
        change = (dwell.torque_reference_nm or 0.0) * dwell.duration / inertia
        doubt = UNCERTAIN * abs(change)
        friction = float(friction_torque(drive.plant(dwell.scales), max(abs(slowest), abs(fastest))))
        held_back = friction * dwell.duration / inertia
        # Friction holds back either way, and stops a shaft at most.
        slowest = slowest + change - doubt - (held_back if slowest > 0.0 else 0.0)
        fastest = fastest + change + doubt + (held_back if fastest < 0.0 else 0.0)
        if max(abs(slowest), abs(fastest)) > highest:
            return "its torque turns a shaft that nothing holds beyond the highest speed"
    if scenario.drive.one_way_because is not None and slowest < 0.0:
        return f"its torque turns a shaft that nothing holds backward, but {scenario.drive.one_way_because}"
    return None


def is_stalled(scenario: Scenario) -> bool:
    """Return True if a run begins with a shaft at rest that no drive turns."""
    friction = (scenario.drift.friction_n_m if scenario.drift is not None else None) or ((0.0, 0.0),)
    most = STALLING_SHARE * scenario.drive.rating.rated_torque_nm
    return scenario.initial_speed_rpm == 0.0 and friction[0][1] >= (1.0 - UNCERTAIN) * most
