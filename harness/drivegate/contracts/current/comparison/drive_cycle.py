"""A drive cycle as a run of the drive in a vehicle of its size, and what a candidate spends on it.

The drive cannot brake: a current reference is 0 or more. So the driver's mechanical brake is a force along the road,
as large as the cycle's slowing down needs beyond what the vehicle loses by itself, which the plant takes as a grade of
the road. It is applied while the cycle slows down and while it stands still.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise
from typing import Any, Final

import numpy as np

from drivegate.scenarios.drive_scale import scale_of, tidy
from drivegate_cases.documents.wording import significant
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.drive_cycle import DriveCycle
from drivegate_cases.scenario.load import GRAVITY, VehicleLoad
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.scenario import LONGEST_CONTROL_PERIOD_S, Scenario
from drivegate_cases.scenario.sensors import IDEAL, real_sensors
from drivegate_models.errors import InputError
from drivegate_models.loop import observation
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.units import RADIANS_PER_RPM

_MASS_UNITS: Final = 2.6
_GEAR_UNITS: Final = 3.0
_DRAG_AREA_M2_PER_W: Final = 0.4 / 1500.0
_OVERSPEED_RPM_PER_GEAR: Final = 600.0
TOLERANCE_KM_H: Final = 2.0
"""Deviation from the cycle's speed that the type approval test allows (km/h)."""
HARDEST_BRAKING_M_S2: Final = 6.0
"""Deceleration that no cycle may exceed (m/s²)."""
STANDING_BRAKE: Final = 0.05
"""Force of the brake at a stop, over the vehicle's weight (1)."""
SAMPLE_S: Final = 0.5
"""Time between two kept samples (s)."""
_PIECE_S: Final = 1.0
_KEPT: Final = 100
PHASES: Final = ("accelerating", "cruising", "slowing", "standing")
"""Kinds of stretches of a cycle."""


@lru_cache(maxsize=_KEPT)
def cycle_vehicle(drive: DriveDocument) -> VehicleLoad:
    """Return the vehicle of a drive.

    On 1.5 kW at 1500 rpm it is a light electric scooter with its rider, 130 kg behind a gear of 3: at 50 km/h, and at
    the end of the hardest acceleration of the urban cycle, it takes what the drive can just give. Mass and drag area
    are in proportion to rated power, the gear to the highest speed, so that this holds of other drives; where overspeed
    is little more than that, the gear is smaller, and 50 km/h stay 13 % below overspeed.
    """
    scale = scale_of(drive)
    return VehicleLoad(
        kind="vehicle",
        mass_kg=tidy(_MASS_UNITS * scale.mass_unit_kg),
        wheel_radius_m=0.25,
        gear_ratio=min(
            tidy(_GEAR_UNITS * scale.gear_unit), significant(scale.overspeed_rpm / _OVERSPEED_RPM_PER_GEAR, 2)
        ),
        rolling_resistance=0.010,
        drag_area_m2=significant(_DRAG_AREA_M2_PER_W * drive.rating.rated_power_w, 2),
    )


def cycle_scenario(cycle: DriveCycle, drive: DriveDocument, *, noise_seed: int | None = None) -> Scenario:
    """Make the run of a drive cycle."""
    period = LONGEST_CONTROL_PERIOD_S
    periods = math.ceil(cycle.duration_s / period - 1e-6)
    vehicle = cycle_vehicle(drive)
    rpm_per_km_h = 1.0 / 3.6 / vehicle.lever_m / RADIANS_PER_RPM
    load = vehicle.model_copy(update={"grade_percent": braking_grade(cycle, drive)})
    return Scenario(
        name=f"cycle-{cycle.name}"[:200],
        drive=drive,
        duration_s=round(periods * period, 9),
        initial_speed_rpm=round(cycle.speed_km_h[0][1] * rpm_per_km_h, 6),
        speed_rpm=tuple((time, round(speed * rpm_per_km_h, 6)) for time, speed in cycle.speed_km_h),
        load=load,
        sensors=IDEAL if noise_seed is None else real_sensors(drive),
        seed=noise_seed or 0,
    )


def braking_grade(cycle: DriveCycle, drive: DriveDocument) -> Profile:
    """Return the driver's brake as a grade of the road."""
    points: list[tuple[float, float]] = []
    for (start, first), (end, last) in pairwise(cycle.speed_km_h):
        pieces = math.ceil((end - start) / _PIECE_S) if last < first else 1
        deceleration = (first - last) / 3.6 / (end - start)
        if deceleration > HARDEST_BRAKING_M_S2:
            raise InputError(
                f"the drive cycle '{cycle.name}' slows down by {deceleration:.3g} m/s² at {start:g} s, but may by "
                f"{HARDEST_BRAKING_M_S2:g} m/s² at most"
            )
        for piece in range(pieces + 1):
            share = piece / pieces
            speed = (first + share * (last - first)) / 3.6
            grade = _grade(deceleration, speed, drive, standing=first == last == 0.0)
            point = (round(start + share * (end - start), 9), grade)
            if not points or points[-1] != point:
                points.append(point)
    return tuple(points)


def _grade(deceleration: float, speed: float, drive: DriveDocument, *, standing: bool) -> float:
    """Return the grade whose weight along the road is the brake's force (%)."""
    if standing:
        return round(100.0 * STANDING_BRAKE, 6)
    if deceleration <= 0.0:
        return 0.0
    vehicle = cycle_vehicle(drive)
    weight, lever = vehicle.mass_kg * GRAVITY, vehicle.lever_m
    inertial = (vehicle.mass_kg + drive.machine.inertia_kg_m2 / (lever * lever)) * deceleration
    by_itself = vehicle.torque_at(speed / lever / RADIANS_PER_RPM) / lever
    share = min(max((inertial - by_itself) / weight, 0.0), 0.7)
    return round(100.0 * share / math.sqrt(1.0 - share * share), 6)


def cycle_figures(scenario: Scenario, run: ClosedLoopRun) -> dict[str, Any]:
    """Return what a candidate spent on a cycle, and how well it followed."""
    period = scenario.control_period_s
    columns = {name: run.trace[name] for name in observation.TRACE_COLUMNS}
    km_h = RADIANS_PER_RPM * cycle_vehicle(scenario.drive).lever_m * 3.6
    speed, speed_reference = columns["speed_rpm"] * km_h, columns["speed_reference_rpm"] * km_h
    power, error = columns["input_power_w"], speed - speed_reference
    energy = run.observed.input_energy / 3600.0
    distance = float(speed.sum()) * period / 3600.0
    energy_by_phase = {
        phase: float(power[inside].sum()) * period / 3600.0
        for phase, inside in _phases(scenario, columns["time_s"]).items()
    }
    return {
        "energy_wh": energy,
        "distance_km": distance,
        "energy_wh_per_km": energy / distance if distance > 0.0 else None,
        "shaft_energy_wh": run.observed.shaft_energy / 3600.0,
        "energy_wh_by_phase": energy_by_phase,
        "current_sum_mean_a": float(columns["current_sum_a"].mean()),
        "tracking_error_rms_km_h": float(np.sqrt(np.mean(error * error))),
        "tracking_error_worst_km_h": float(error[np.abs(error).argmax()]),
        "outside_tolerance_s": float((np.abs(error) > TOLERANCE_KM_H).sum()) * period,
        "samples": _samples(columns, speed, speed_reference, period),
    }


def _phases(scenario: Scenario, times: Any) -> dict[str, Any]:
    """Return for each kind of stretch which control periods belong to it."""
    points = np.array(scenario.speed_rpm)
    stretch = np.clip(np.searchsorted(points[:, 0], times, side="right") - 1, 0, len(points) - 2)
    change = np.sign(points[stretch + 1, 1] - points[stretch, 1])
    moving = np.maximum(points[stretch + 1, 1], points[stretch, 1]) > 0.0
    return {
        "accelerating": change > 0,
        "cruising": (change == 0) & moving,
        "slowing": change < 0,
        "standing": (change == 0) & ~moving,
    }


def _samples(
    columns: dict[str, Any], speed: Any, speed_reference: Any, period: float
) -> dict[str, list[float]]:
    block = max(round(SAMPLE_S / period), 1)
    whole = len(speed) // block * block
    power = columns["input_power_w"][:whole].reshape(-1, block).mean(axis=1)
    energy = np.cumsum(columns["input_power_w"]) * period / 3600.0
    return {
        "time_s": [round(float(value), 6) for value in columns["time_s"][:whole:block]],
        "speed_reference_km_h": [round(float(value), 4) for value in speed_reference[:whole:block]],
        "speed_km_h": [round(float(value), 4) for value in speed[:whole:block]],
        "input_power_w": [round(float(value), 3) for value in power],
        "energy_wh": [round(float(value), 5) for value in energy[:whole:block]],
    }
