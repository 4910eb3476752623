"""The fixed runs of operations that are rarely tried, in which firmware has failed in the field."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from types import MappingProxyType
from typing import Final, TypeAlias

from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.building import (
    dwell_periods,
    hoist_scenario,
    load_step_scenario,
    restarted,
    share_scenario,
    speed_scenario,
    start_s,
    supply_step_scenario,
    torque_of,
    vanishing_load_scenario,
    with_lost_samples,
)
from drivegate.contracts.duty.scenarios.drawn_range import BEYOND_SHARE, HEAVIEST_SHARE, speed_of
from drivegate.contracts.duty.scenarios.windows import WINDOW_SHARE, is_held, settling_s
from drivegate.scenarios.changes import TWENTY, in_steps
from drivegate.scenarios.clocks import wraps_s
from drivegate.scenarios.drive_scale import tidy
from drivegate.scenarios.title import titled
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.load import SwitchedLoad
from drivegate_cases.scenario.reference import FollowedReference, reference_of
from drivegate_cases.scenario.scenario import Scenario

RareRuns: TypeAlias = Callable[[PmAcDocument], list[Scenario]]
"""From a drive to the runs of one kind."""

WRAP_SHARE: Final = 1.0 + 0.25 * WINDOW_SHARE
"""Time from the start of a run to that at which its clock wraps around, over the settling time (1)."""
LONG_S: Final = 75.0
"""Length of the long run (s): more than a minute, in which a winding heats up and milliseconds in 16 bits wrap."""
LONG_RATE_HZ: Final = 10_000.0
"""Control rate up to which runs have these lengths; at a higher one they have as many control periods (Hz)."""
NIGHTLY_S: Final = 150.0
"""Length of the runs of some minutes (s)."""
SMALL_SHARE: Final = 0.04
"""A small torque reference over rated torque, whose steps are too small to be judged as such (1)."""
WEIGHT_SHARE: Final = 0.6
"""Weight of a hoist that is held at rest, over rated torque (1)."""


def rare_scenarios(drive: PmAcDocument, *, reverses: bool = True) -> list[Scenario]:
    """List the runs of every kind, those of a hoist only where the candidate reverses."""
    kinds = {**RARE, **(RARE_BACKWARD if reverses else {})}
    return [run for runs in kinds.values() for run in runs(drive)]


def _falls_at_limit(drive: PmAcDocument) -> list[Scenario]:
    if not drive.weakens:
        return []
    return [
        share_scenario(drive, speed_of(drive, 0.5), BEYOND_SHARE, 0.4, BEYOND_SHARE, 0.15),
        share_scenario(drive, speed_of(drive, 1.0), BEYOND_SHARE, 0.3),
    ]


def _stop_from_top(drive: PmAcDocument) -> list[Scenario]:
    """Make the run that stops from the highest speed, turns again, and is loaded then."""
    slow = speed_of(drive, -0.5)
    torque = torque_of(drive, slow, WEIGHT_SHARE)
    return [_loaded_later(speed_scenario(drive, (speed_of(drive, 1.0), 0.0, slow), torque_nm=torque), 0.0)]


def _loaded_later(run: Scenario, share: float) -> Scenario:
    """Go on with a run under its whole load, which has a share of it until then."""
    drive = duty_document(run.drive)
    periods = round(run.duration_s / drive.control_period_s)
    assert isinstance(run.load, SwitchedLoad)
    factor = in_steps((share, 1.0), (start_s(drive, periods),))
    end = start_s(drive, periods + dwell_periods(drive))
    return titled(run.replaced(duration_s=end, load=run.load.model_copy(update={"factor": factor})))


def _late_clocks(drive: PmAcDocument) -> list[Scenario]:
    """Make the runs in which the clock wraps around while a steady state is judged, before the reference changes."""
    slow = speed_of(drive, -0.5)
    runs = (
        share_scenario(drive, slow, 0.6, 0.3),
        speed_scenario(drive, (slow, tidy(1.1 * slow)), torque_nm=torque_of(drive, slow, 0.6)),
    )
    return [
        restarted(run, (), round(wrap - before, 6))
        for wrap in wraps_s(drive.control_period_s)
        for run in runs
        if (before := WRAP_SHARE * settling_s(drive, held=is_held(run))) < wrap
    ]


def _small_references(drive: PmAcDocument) -> list[Scenario]:
    small = (SMALL_SHARE, -SMALL_SHARE)
    return [share_scenario(drive, speed_of(drive, at), *small) for at in (-0.5, 0.3)]


def _held_weights(drive: PmAcDocument) -> list[Scenario]:
    """Make the run in which a weight is lowered, stopped and held, and then doubled."""
    slow = speed_of(drive, -0.5)
    run = hoist_scenario(drive, (-slow, 0.0), torque_of(drive, slow, WEIGHT_SHARE))
    return [_loaded_later(run, 0.5)]


def _rated_loads(drive: PmAcDocument) -> list[Scenario]:
    slow, base = speed_of(drive, -0.5), speed_of(drive, 0.0)
    return [
        load_step_scenario(drive, speed, torque_of(drive, speed, 1.0), (0.9, 1.0)) for speed in (slow, base)
    ]


def _rated_lowering(drive: PmAcDocument) -> list[Scenario]:
    slow = speed_of(drive, -0.5)
    return [hoist_scenario(drive, (-slow,), torque_of(drive, slow, 1.0), (0.9, 1.0))]


def _lost_samples(drive: PmAcDocument) -> list[Scenario]:
    """Make the runs in which samples of each signal are lost twenty times."""
    slow = speed_of(drive, -0.5)
    signals = ("currents", *(("speed",) if drive.has_sensor else ()), "supply")
    shares = tuple(0.1 + 0.01 * number for number in range(TWENTY))
    runs = (
        share_scenario(drive, slow, 0.6),
        speed_scenario(drive, (slow,), torque_nm=torque_of(drive, slow, 0.6)),
    )
    return [with_lost_samples(run, signals, shares) for run in runs]


def _link_while_braking(drive: PmAcDocument) -> list[Scenario]:
    top = speed_of(drive, 1.0)
    return [supply_step_scenario(share_scenario(drive, top, -0.8), drive, (1.0, 1.15, 0.85, 1.15))]


def _link_while_driving(drive: PmAcDocument) -> list[Scenario]:
    """Make the run whose link steps below base speed, where its lower voltage suffices."""
    below = speed_of(drive, -0.35)
    return [supply_step_scenario(share_scenario(drive, below, 0.9), drive, (0.85, 1.15, 0.85))]


def _minutes(drive: PmAcDocument) -> list[Scenario]:
    slow = speed_of(drive, -0.5)
    return [_lasting(speed_scenario(drive, (slow,), torque_nm=torque_of(drive, slow, 0.9)), LONG_S)]


def nightly_scenarios(drive: PmAcDocument, references: Collection[FollowedReference]) -> tuple[Scenario, ...]:
    """List the runs of some minutes that are made every night, of the references that a candidate follows."""
    fast, base = speed_of(drive, 0.3), speed_of(drive, 0.0)
    runs = [
        speed_scenario(drive, (fast,), torque_nm=torque_of(drive, fast, HEAVIEST_SHARE)),
        share_scenario(drive, base, 0.9),
    ]
    return tuple(_lasting(run, NIGHTLY_S) for run in runs if reference_of(run) in references)


def _lasting(run: Scenario, duration_s: float) -> Scenario:
    """Lengthen a run, by whole control periods; less at a high rate, at which it would take gigabytes."""
    drive = duty_document(run.drive)
    periods = min(round(duration_s / drive.control_period_s), round(duration_s * LONG_RATE_HZ))
    lasting = start_s(drive, periods)
    return titled(run.replaced(duration_s=lasting)) if lasting > run.duration_s else run


def _small_speed_steps(drive: PmAcDocument) -> list[Scenario]:
    slow = speed_of(drive, -0.5)
    return [
        speed_scenario(
            drive, (slow, tidy(1.1 * slow), slow), torque_nm=torque_of(drive, slow, HEAVIEST_SHARE)
        )
    ]


def _large_torque_steps(drive: PmAcDocument) -> list[Scenario]:
    return [share_scenario(drive, speed_of(drive, -0.35), 1.0, -1.0, 1.0)]


def _load_gone(drive: PmAcDocument) -> list[Scenario]:
    """Make the run whose load is gone near base speed until the speed has settled, and comes back."""
    near = speed_of(drive, -0.05)
    gone = start_s(drive, dwell_periods(drive))
    return [vanishing_load_scenario(drive, near, torque_of(drive, near, HEAVIEST_SHARE), gone)]


RARE: Final[Mapping[str, RareRuns]] = MappingProxyType(
    {
        "torque that falls at the voltage limit": _falls_at_limit,
        "stop from deep weakening": _stop_from_top,
        "clocks": _late_clocks,
        "small references": _small_references,
        "rated torque under a speed reference": _rated_loads,
        "repeated lost samples": _lost_samples,
        "link steps while braking at top speed": _link_while_braking,
        "link steps below base speed": _link_while_driving,
        "minutes": _minutes,
        "transients of the speed": _small_speed_steps,
        "large torque steps": _large_torque_steps,
        "load that is gone for a moment": _load_gone,
    }
)
"""The kinds of operation, by their names, each with its runs."""
RARE_BACKWARD: Final[Mapping[str, RareRuns]] = MappingProxyType(
    {"hoist at zero speed": _held_weights, "lowering a rated load": _rated_lowering}
)
"""Those of candidates that reverse."""
