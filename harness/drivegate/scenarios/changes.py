"""One change at a time to a plain scenario: load, speed, supply, plant, sensors and faults."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any, Final

from drivegate.scenarios.drive_scale import scale_of, tidy, whole_tenths
from drivegate.scenarios.title import titled
from drivegate_cases.scenario.control_periods import on_whole_periods
from drivegate_cases.scenario.courses import Drift
from drivegate_cases.scenario.disturbance import CurrentError, Dropout, Glitch
from drivegate_cases.scenario.load import LockedLoad, VehicleLoad
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import real_sensors

CLOCKS_S: Final = (0.0, 60.0, 2145.0, 4290.0, 86400.0, 2147480.0, 4294960.0)
"""Where the clock is drawn to begin: also just before 2³¹ and 2³² µs and ms have passed (s)."""
TWENTY = 20
"""Number of times that something happens that is repeated (1)."""


def stepped(before: float, after: float, at_s: float, *, over_s: float = 0.0) -> Profile:
    """Make a profile that changes once."""
    return ((0.0, before), (at_s, before), (tidy(at_s + over_s), after))


def in_steps(values: Sequence[float], times_s: Iterable[float]) -> Profile:
    """Make a profile that changes at once from each value to the next, at some times."""
    steps = zip(pairwise(values), times_s, strict=True)
    changes = (point for (before, after), at in steps for point in ((at, before), (at, after)))
    return ((0.0, values[0]), *changes)


def pulsed(before: float, during: float, at_s: float, lasts_s: float) -> Profile:
    """Make a profile that changes and comes back."""
    back = tidy(at_s + lasts_s)
    return ((0.0, before), (at_s, before), (at_s, during), (back, during), (back, before))


def repeated(before: float, during: float, at_s: float, *, every_s: float, times: int = TWENTY) -> Profile:
    """Make a profile that changes and comes back again and again, half of the time each."""
    points = [(0.0, before)]
    for number in range(times):
        begin = tidy(at_s + number * every_s)
        back = tidy(begin + 0.5 * every_s)
        points += [(begin, before), (begin, during), (back, during), (back, before)]
    return tuple(points)


def moments(at_s: float, *, every_s: float) -> tuple[float, ...]:
    """List the times of something that happens again and again."""
    return tuple(tidy(at_s + number * every_s) for number in range(TWENTY))


def coming_on_to(ramp_s: float, share: float, later: Profile = ()) -> Profile:
    """Return the shares of a load that comes on to one of them, and changes later, at the earliest when it is there."""
    there = (ramp_s, share)
    return ((0.0, 0.0), there, *(later[1:] if later[:1] == (there,) else later))


def with_load_shares(scenario: Scenario, *changes: tuple[float, float]) -> Scenario:
    """Step a switched load."""
    shares = in_steps([share for _, share in changes], [time for time, _ in changes[1:]])
    return with_load_factor(
        scenario, coming_on_to(scale_of(scenario.drive).load_ramp_s, changes[0][1], shares[1:])
    )


def with_load_factor(scenario: Scenario, factor: Profile) -> Scenario:
    load = scenario.load
    assert not isinstance(load, (LockedLoad, VehicleLoad)), "only a switched load has shares"
    return _with_change(scenario, factor[-1][0], load=load.model_copy(update={"factor": factor}))


def with_speed(scenario: Scenario, profile: Profile) -> Scenario:
    return _with_change(scenario, profile[-1][0], speed_rpm=profile, initial_speed_rpm=profile[0][1])


def with_supply(scenario: Scenario, profile: Profile) -> Scenario:
    """Change the voltage of the supply during a run."""
    nominal = scenario.drive.inverter.supply_voltage_v
    volts = tuple((time, tidy(share * nominal)) for time, share in profile)
    return _with_change(scenario, profile[-1][0], supply_v=volts)


def with_scales(scenario: Scenario, **factors: float) -> Scenario:
    return titled(scenario.replaced(scales=factors))


def with_real_sensors(scenario: Scenario, seed: int) -> Scenario:
    """Put the sensors that the drive has between plant and controller."""
    return titled(scenario.replaced(sensors=real_sensors(scenario.drive).kind, seed=seed))


def with_beginning(scenario: Scenario, **changes: float) -> Scenario:
    """Change control period, clock or rotor angle at the start."""
    return titled(scenario.replaced(**changes))


def with_restarts(scenario: Scenario, *times_s: float) -> Scenario:
    """Reset the controller while the drive runs on."""
    return _with_change(scenario, times_s[-1], restarts_s=(*scenario.restarts_s, *times_s))


def with_current_error(
    scenario: Scenario, phase: int, *, gain: float = 1.0, offset_a: float = 0.0
) -> Scenario:
    error = CurrentError(phase=phase, gain=gain, offset_a=offset_a)
    return titled(scenario.replaced(current_errors=(*scenario.current_errors, error)))


def with_dropout(
    scenario: Scenario, signal: str, at_s: float, lasts_s: float, *, phase: int | None = None
) -> Scenario:
    """Lose a sensor's signal for a moment, or that of one phase alone."""
    lost = Dropout.model_validate({"signal": signal, "phase": phase, "start_s": at_s, "duration_s": lasts_s})
    return _with_change(scenario, lost.end_s, dropouts=(*scenario.dropouts, lost))


def with_lost_samples(scenario: Scenario, phase: int, times_s: Iterable[float]) -> Scenario:
    """Lose single samples of the current of a phase."""
    for time in times_s:
        scenario = with_dropout(scenario, "currents", time, scenario.control_period_s, phase=phase)
    return scenario


def with_glitch(scenario: Scenario, counts: int, at_s: float) -> Scenario:
    return _with_change(scenario, at_s, glitches=(*scenario.glitches, Glitch(time_s=at_s, counts=counts)))


def with_imbalance(scenario: Scenario, profile: Profile) -> Scenario:
    return _with_change(scenario, profile[-1][0], imbalance=profile)


def with_drift(scenario: Scenario, **drifts: Profile | None) -> Scenario:
    """Let parameters, by the names of their keys, drift during a run."""
    drift = Drift.model_validate(drifts)
    last = max(profile[-1][0] for profile in drifts.values() if profile is not None)
    return _with_change(scenario, last, drift=drift)


def _with_change(scenario: Scenario, over_at_s: float, **changes: Any) -> Scenario:
    """Apply a change that is over at a time, and leave a whole steady stretch behind it."""
    tenths = whole_tenths(over_at_s + scale_of(scenario.drive).dwell_s)
    long_enough = on_whole_periods(tenths, scenario.control_period_s)
    return titled(scenario.replaced(duration_s=max(scenario.duration_s, long_enough), **changes))
