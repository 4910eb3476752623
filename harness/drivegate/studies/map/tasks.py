"""The part of an operating map that one task does: steady states, best angles, or closed-loop runs."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from math import degrees, isfinite, nan
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.fault import Fault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import contained_runs
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.pool import WorkerPool
from drivegate.contracts.current.checks.convergence import window_convergence
from drivegate.contracts.current.record import CurrentRecord, SteadyWindow
from drivegate.contracts.current.scenarios.building import coming_on
from drivegate.drives.running import recorded
from drivegate.scenarios.drive_scale import scale_of, tidy
from drivegate.studies.map.plan import (
    ADVANCE,
    BEST_COLUMNS,
    CONVERGED,
    CURRENT,
    LOOP_COLUMNS,
    NOT_CONVERGED,
    NOT_FEASIBLE,
    SPEED,
    TORQUE,
    MapPlan,
    drives_of,
)
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.plant import Scales
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_cases.scenario.profile import dwells
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.compilation.kernels import required_cache_folder
from drivegate_models.errors import HarnessFault
from drivegate_models.machine.friction import friction_torque
from drivegate_models.steady import oracle
from drivegate_models.steady.grid import POINT_COLUMNS, solve_points
from drivegate_models.steady.plant import AnyDrive, make_phases
from drivegate_models.steady.steady_state import KEPT_TIME
from drivegate_models.units import RADIANS_PER_RPM

SOLVER_MARKER: Final = "map-solver"
"""Name of the file in the cache folder that shows that the solver of many steady states has been compiled."""


@dataclass(frozen=True)
class MapPart:
    """Some points of a map."""

    values: NDArray[np.float64]
    """What was computed, shape (points, columns)."""
    verdicts: tuple[str, ...] = ()
    """What became of each closed-loop run; empty of other maps."""


def compute_piece(package: bytes, piece: tuple[int, int]) -> MapPart:
    """Compute some points; this is what a worker does."""
    plan: MapPlan = pickle.loads(package)
    task = {"points": _points, "best": _best, "loop": _loop}[plan.kind]
    return task(plan, *piece)


def compile_solver(package: bytes, kind: str) -> None:
    """Have a kind of drive's solver of steady states compiled in a process of its own, unless it is kept from before.

    So that all processes that compute a map run the same code, which they load.
    """
    marker = required_cache_folder() / f"{SOLVER_MARKER}-{kind}"
    if marker.exists():
        return
    with WorkerPool(resolve_candidate("initial"), workers=1) as pool:
        ended = next(pool.map([Job(_first_point, package)]))
    if isinstance(ended, Fault):
        raise HarnessFault(f"the solver of steady states cannot be compiled: {ended.message}")
    marker.touch()


def _first_point(_loaded: JudgedCandidate, package: bytes) -> None:
    compute_piece(package, (0, 1))


def _points(plan: MapPlan, first: int, last: int) -> MapPart:
    at = plan.axes.coordinates(first, last)
    values = np.full((last - first, len(POINT_COLUMNS)), nan)
    for piece, drive, scales in drives_of(plan, at):
        plant = drive.plant(scales)
        solve_points(
            plant,
            make_phases(plant, KEPT_TIME),
            make_phases(plant),
            plant.half_supply_voltage,
            at[SPEED][piece] * RADIANS_PER_RPM,
            np.radians(at[ADVANCE][piece]),
            at[CURRENT][piece],
            values[piece],
        )
    # A current beyond the limit is never requested, so what it would give is nobody's operating point.
    for piece, drive, _ in drives_of(plan, at):
        values[piece][at[CURRENT][piece] > drive.rating.current_limit_a] = nan
    return MapPart(values)


def _best(plan: MapPlan, first: int, last: int) -> MapPart:
    at = plan.axes.coordinates(first, last)
    values = np.full((last - first, len(BEST_COLUMNS)), nan)
    for piece, drive, scales in drives_of(plan, at):
        plant = drive.plant(scales)
        for place in range(piece.start, piece.stop):
            speed, torque = float(at[SPEED][place]) * RADIANS_PER_RPM, float(at[TORQUE][place])
            edge = oracle.feasible_edge(plant, speed, torque)
            if isfinite(edge):
                best = oracle.least_current_sum(plant, speed, torque)
                shaft = speed * torque
                values[place] = (
                    degrees(edge),
                    degrees(best.advance),
                    best.reference,
                    best.current_sum,
                    best.input_power,
                    shaft,
                    shaft / best.input_power,
                )
    return MapPart(values)


def _loop(plan: MapPlan, first: int, last: int) -> MapPart:
    assert plan.candidate is not None, "a map of closed-loop runs is a candidate's"
    at = plan.axes.coordinates(first, last)
    scenarios = [
        _steady(drive, scales, float(at[SPEED][place]), float(at[TORQUE][place]))
        for piece, drive, scales in drives_of(plan, at)
        for place in range(piece.start, piece.stop)
    ]
    values = np.full((last - first, len(LOOP_COLUMNS)), nan)
    verdicts = []
    for place, ending in enumerate(contained_runs(plan.candidate, _run_point, scenarios)):
        if isinstance(ending, Fault):
            verdicts.append(ending.kind.value)
        else:
            verdict, found = ending
            verdicts.append(verdict)
            values[place] = found
    return MapPart(values, tuple(verdicts))


def _steady(drive: DriveDocument, scales: Scales, speed_rpm: float, torque: float) -> Scenario:
    scale = scale_of(drive)
    return Scenario(
        name=f"{speed_rpm:g} rpm, {torque:g} N·m",
        drive=drive,
        scales=scales,
        duration_s=tidy(scale.load_ramp_s + scale.dwell_s),
        initial_speed_rpm=speed_rpm,
        speed_rpm=((0.0, speed_rpm),),
        load=ConstantTorqueLoad(kind="constant_torque", torque_nm=torque, factor=coming_on(drive)),
    )


def _run_point(loaded: JudgedCandidate, scenario: Scenario) -> tuple[str, tuple[float, ...]]:
    drive = scenario.drive.plant(scenario.scales)
    if not _is_feasible(scenario, drive):
        return NOT_FEASIBLE, (nan,) * len(LOOP_COLUMNS)
    record = recorded(loaded, scenario, loaded.controller())
    assert isinstance(record, CurrentRecord), "a map is over angles, which only this contract has"
    return _measured(record, drive)


def _is_feasible(scenario: Scenario, drive: AnyDrive) -> bool:
    speed_rpm, load = scenario.initial_speed_rpm, scenario.load
    assert isinstance(load, ConstantTorqueLoad), "points of a map have a load of constant torque"
    speed = speed_rpm * RADIANS_PER_RPM
    torque = load.torque_nm + friction_torque(drive, speed)
    if speed_rpm <= scenario.drive.rating.base_speed_rpm:
        # There is no advance below base speed.
        return oracle.point_at_torque(drive, speed, 0.0, torque).robust
    return isfinite(oracle.feasible_edge(drive, speed, torque))


def _measured(record: CurrentRecord, drive: AnyDrive) -> tuple[str, tuple[float, ...]]:
    scenario = record.scenario
    window = SteadyWindow(scenario, dwells(scenario)[-1], record.run.windows[-1])
    margin, _ = window_convergence(window)
    row = window.values
    torque, speed = row.torque, row.speed
    current_sum, input_power = row.current_sum, row.input_power
    least = nan
    if scenario.initial_speed_rpm > scenario.drive.rating.base_speed_rpm and torque > 0.0 < speed:
        least = oracle.least_current_sum(drive, speed, torque).current_sum
    shaft = window.torque_required * speed
    values = (
        margin,
        row.speed_error / RADIANS_PER_RPM,
        degrees(row.angle),
        row.reference,
        current_sum,
        least,
        100.0 * (current_sum / least - 1.0),
        input_power,
        shaft,
        shaft / input_power if input_power > 0.0 else nan,
        100.0 * row.ripple,
        row.peak,
    )
    return CONVERGED if margin >= 0.0 else NOT_CONVERGED, values
