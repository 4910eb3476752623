"""Each check of duty ratios is met by field-oriented control, and notices a run in which what it judges was another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.harness.contracts.duty.checks.conftest import CHECKS, Run, judged, with_column, with_command
from tests.harness.contracts.reading import is_read, read_off

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import on_drive
from drivegate.contracts.duty.checks.judged import greatest_at, least_free, undistorted
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import (
    failing,
    hoist_scenario,
    speed_scenario,
    supply_step_scenario,
    torque_of,
    torque_scenario,
    with_edges,
)
from drivegate.contracts.recorded_trace import deciding_moment
from drivegate.drives.running import recorded
from drivegate.scenarios.changes import with_scales
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.duty.signals import LEG_PWM
from drivegate_models.machine import shaft_ledger
from drivegate_models.units import RADIANS_PER_RPM


@pytest.fixture(scope="session")
def steps(run: Run, interior: PmAcDocument) -> DutyRecord:
    """Give steps of the torque below base speed, where the voltage is free."""
    speed = 0.6 * interior.rating.base_speed_rpm
    return run(
        torque_scenario(interior, speed, [torque_of(interior, speed, part) for part in (0.0, 0.5, 0.35)])
    )


@pytest.fixture(scope="session")
def weakened(run: Run, interior: PmAcDocument) -> DutyRecord:
    """Give more torque than there is at twice base speed, and none after it."""
    speed = 2.0 * interior.rating.base_speed_rpm
    return run(torque_scenario(interior, speed, (0.0, torque_of(interior, speed, 3.0), 0.0)))


@pytest.fixture(scope="session")
def start(run: Run, interior: PmAcDocument) -> DutyRecord:
    return run(
        speed_scenario(interior, (420.0,), torque_nm=1.0, initial_speed_rpm=0.0, initial_angle_deg=120.0)
    )


@pytest.fixture(scope="session")
def other_plant(run: Run, interior: PmAcDocument) -> DutyRecord:
    return run(with_scales(speed_scenario(interior, (1000.0, 1500.0), torque_nm=0.8), emf_constant=0.8))


@pytest.fixture(scope="session")
def sensed(run: Run, interior: PmAcDocument) -> DutyRecord:
    """Give torques below base speed, seen through shunts below the lower switches and an encoder."""
    return run(through(interior, shunts="low-side"))


def through(interior: PmAcDocument, **keys: Any) -> Scenario:
    """Make steps of the torque below base speed, seen through sensors."""
    speed = 0.4 * interior.rating.base_speed_rpm
    torques = [torque_of(interior, speed, part) for part in (0.2, 0.8)]
    return torque_scenario(interior, speed, torques).replaced(sensors={"kind": "shunts", **keys}, seed=7)


@pytest.fixture(scope="session")
def slow(run: Run, interior: PmAcDocument) -> DutyRecord:
    """Give a torque at 8 % of base speed, which is also run with another dead time."""
    speed = 0.08 * interior.rating.base_speed_rpm
    return run(torque_scenario(interior, speed, (torque_of(interior, speed, 0.5),)))


@pytest.fixture(scope="session")
def stuck(run: Run, interior: PmAcDocument) -> DutyRecord:
    """Give a torque at base speed, in whose course a current sensor gets stuck."""
    speed = interior.rating.base_speed_rpm
    held = torque_scenario(interior, speed, (torque_of(interior, speed, 0.5),))
    return run(failing(held, "stuck-current", 0.3, 2))


@pytest.fixture(scope="session")
def locked(run: Run, interior: PmAcDocument) -> DutyRecord:
    """Give a start with a shaft that is locked."""
    start = speed_scenario(interior, (1500.0,), torque_nm=1.0, initial_speed_rpm=0.0)
    return run(failing(start, "locked-rotor", 0.0))


@pytest.fixture(scope="session")
def edge(run: Run, interior: PmAcDocument) -> DutyRecord:
    """Give a torque at base speed, in whose course an edge of the Hall switches is lost."""
    speed = interior.rating.base_speed_rpm
    held = torque_scenario(interior, speed, (torque_of(interior, speed, 0.5),))
    return run(failing(with_edges(held, "hall", 1), "lost-edge", 0.3))


RUNS = {
    "edge": ("PWR-1", "DUT-1", "OVC-1", "SAF-1"),
    "slow": ("PWR-1", "DUT-1", "ACC-1", "RIP-4", "DTM-1", "FWK-2", "MTP-1", "OVC-1", "OVC-2", "EST-1"),
    "stuck": ("PWR-1", "DUT-1", "OVC-1", "SAF-1"),
    "locked": ("PWR-1", "DUT-1", "OVC-1", "SAF-1"),
    "steps": (
        "PWR-1",
        "DUT-1",
        "ACC-1",
        "STP-1",
        "DEC-1",
        "RIP-4",
        "FWK-2",
        "MTP-1",
        "OVC-1",
        "OVC-2",
        "EST-1",
    ),
    "weakened": ("PWR-1", "DUT-1", "ACC-1", "FWK-1", "FWK-2", "FWK-3", "OVC-1", "OVC-2", "EST-1"),
    "start": (
        "PWR-1",
        "DUT-1",
        "ACC-1",
        "RIP-4",
        "FWK-2",
        "MTP-1",
        "OVC-1",
        "OVC-2",
        "STA-1",
        "EST-1",
        "ROB-4",
    ),
    "sensed": ("PWR-1", "DUT-1", "OVC-1", "ROB-5"),
    "other_plant": ("PWR-1", "DUT-1", "OVC-1", "ROB-4"),
}


@pytest.mark.parametrize("name", RUNS)
def test_a_correct_controller_meets_what_a_run_is_judged_by(
    name: str, request: pytest.FixtureRequest
) -> None:
    record = request.getfixturevalue(name)
    margins = {check: margin for check in CHECKS if (margin := judged(check, record)) is not None}
    assert set(margins) == set(RUNS[name])
    failed = {check: margin for check, margin in margins.items() if not margin.met}
    assert {check: margin for check, margin in failed.items() if CHECKS[check].level == "required"} == {}


def _bumped(direct: Any) -> Any:
    """Move a current for half a millisecond behind the last step, the smaller one."""
    changed = direct.copy()
    last = 2 * len(direct) // 3
    changed[last + 10 : last + 15] -= 1.5
    return changed


FAULTS: list[tuple[str, str, str, Callable[[Any], Any]]] = [
    ("ACC-1", "steps", "torque", lambda torque: 1.2 * torque),
    ("STP-1", "steps", "torque", lambda torque: np.convolve(torque, np.ones(60) / 60.0)[: len(torque)]),
    ("DEC-1", "steps", "direct", _bumped),
    ("FWK-2", "steps", "direct", lambda direct: direct - 0.5),
    ("MTP-1", "steps", "quadrature", lambda quadrature: 1.1 * quadrature),
    ("FWK-1", "weakened", "torque", lambda torque: 0.9 * torque),
    ("FWK-3", "weakened", "torque", lambda torque: torque - 0.5),
    ("FWK-3", "weakened", "peak_current", lambda peak: 1.5 * peak),
    ("OVC-2", "weakened", "quadrature", lambda quadrature: 1.1 * quadrature),
    ("STA-1", "start", "speed", lambda speed: 0.5 * speed),
    ("STA-1", "start", "speed", lambda speed: np.where(np.arange(len(speed)) < 500, -20.0, speed)),
    ("ROB-4", "other_plant", "speed", lambda speed: speed + 5.0),
    (
        "SAF-1",
        "stuck",
        "torque",
        lambda torque: np.where(np.arange(len(torque)) >= 3001, torque + 0.6, torque),
    ),
    ("SAF-1", "locked", "torque", lambda torque: torque + 0.6),
    ("SAF-1", "edge", "torque", lambda torque: np.where(np.arange(len(torque)) == 3050, 0.5, torque)),
    (
        "ROB-4",
        "other_plant",
        "speed",
        lambda speed: speed + 4.0 * np.exp(np.arange(len(speed)) / 800.0 - 13.0),
    ),
]


@pytest.mark.parametrize(("check", "name", "column", "change"), FAULTS)
def test_a_run_that_breaks_a_check_is_noticed(
    check: str, name: str, column: str, change: Callable[[Any], Any], request: pytest.FixtureRequest
) -> None:
    record = request.getfixturevalue(name)
    margin = judged(check, with_column(record, column, change))
    assert margin is not None
    assert not margin.met, f"{check} is met with {margin.measured}"


STEADY_MEANS = ("ACC-1", "FWK-1", "FWK-2", "MTP-1", "EFF-1", "OVC-2", "SYM-1", "ROB-5")
"""Checks that state a mean over the stretch that a figure sets off."""
NO_SIGNAL = ("PWR-1", "DET-1", "TIM-1")
"""Checks of the plant, of repetitions and of time, which no signal of a run shows."""
OF_OTHER_DRIVES = ("LNK", "SLS", "THM")
"""Checks of drives with a link or thermal data of their own, or without a position sensor, which have own tests."""


def _behind(share: float, size: float) -> Callable[[Any], Any]:
    """Raise a signal for a tenth of a run, from a share of it on."""
    return lambda values: values + size * _bump(len(values), share)


def _bump(count: int, share: float) -> Any:
    places = np.arange(count) / count - share
    return np.where((places > 0.0) & (places < 0.1), np.sin(np.pi * places / 0.1), 0.0)


def _uneven(record: DutyRecord | None) -> DutyRecord:
    assert record is not None
    unrest = 0.02 * np.where(np.arange(len(record.run.commands)) % 4 < 2, 1.0, -1.0)
    return with_command(record, "first_duty", lambda ratio: ratio + unrest)


def _never_off(record: DutyRecord) -> DutyRecord:
    on = with_command(record, "first_leg", lambda legs: np.full_like(legs, LEG_PWM))
    return with_command(on, "fault", lambda fault: np.where(np.arange(len(fault)) < 4100, 0, fault))


FAILING: list[tuple[str, str, Callable[[DutyRecord], DutyRecord]]] = [
    *(
        (check, name, lambda record, column=column, change=change: with_column(record, column, change))
        for check, name, column, change in FAULTS
        if check not in STEADY_MEANS
    ),
    ("OVC-1", "weakened", lambda record: with_column(record, "peak_current", lambda peak: 3.0 * peak)),
    ("DUT-1", "steps", lambda record: with_command(record, "second_duty", _behind(0.5, 1.0))),
    ("DUT-1", "steps", lambda record: with_command(record, "next_period", lambda values: values + 2e-4)),
    ("EST-1", "steps", lambda record: with_command(record, "torque", lambda torque: torque + 0.5)),
    ("ROB-4", "speeds", lambda record: with_column(record, "speed", _behind(0.5, 60.0))),
    ("ROB-4", "speeds", lambda record: with_column(record, "speed", _behind(0.5, -60.0))),
    ("ROB-4", "loaded", lambda record: with_column(record, "speed", _behind(0.55, 60.0))),
    ("RIP-4", "slow", _uneven),
    ("DTM-1", "slow", lambda record: replace(record, other_dead_time=_uneven(record.other_dead_time))),
    ("SAF-1", "stuck", lambda record: with_command(record, "fault", np.ones_like)),
    ("SAF-1", "stuck", _never_off),
]
"""A failing run of each check whose value is no steady mean."""


@pytest.fixture(scope="session")
def speeds(run: Run, interior: PmAcDocument) -> DutyRecord:
    """Give a step of the speed reference under a load."""
    return run(speed_scenario(interior, (1000.0, 1100.0), torque_nm=0.8))


@pytest.fixture(scope="session")
def loaded(run: Run, interior: PmAcDocument) -> DutyRecord:
    """Give a load that comes at a constant speed reference."""
    settled = speed_scenario(interior, (1000.0,), torque_nm=0.8).duration_s
    factor = ((0.0, 0.2), (settled, 0.2), (settled, 1.0))
    twice = speed_scenario(interior, (1000.0, 1100.0), torque_nm=0.8)
    return run(twice.replaced(speed_rpm=((0.0, 1000.0),), load={**twice.load.model_dump(), "factor": factor}))


def test_every_check_but_those_of_steady_means_is_shown_failing() -> None:
    shown = {check for check, _, _ in FAILING}
    own = {check for check in CHECKS if not check.startswith(OF_OTHER_DRIVES)}
    assert shown == own - {*STEADY_MEANS, *NO_SIGNAL}


@pytest.mark.parametrize(("check", "name", "change"), FAILING)
def test_the_stated_value_can_be_read_off_the_moment_that_is_drawn(
    check: str, name: str, change: Callable[[DutyRecord], DutyRecord], request: pytest.FixtureRequest
) -> None:
    record = change(request.getfixturevalue(name))
    measured, numbers = read_off(CHECKS[check], record)
    assert is_read(measured, numbers), f"{measured!r} is not among {numbers}"
    moment = deciding_moment(CHECKS[check], record, judged(check, record))
    assert 0.0 <= moment.start_s < moment.end_s <= record.scenario.duration_s + 1e-9
    if moment.point is not None:
        assert moment.start_s <= moment.point.time_s <= moment.end_s


def test_the_dead_time_that_is_added_is_stated(slow: DutyRecord) -> None:
    margin = judged("DTM-1", slow)
    assert margin is not None
    assert slow.other_dead_time is not None
    added = 1e6 * slow.other_dead_time.document.inverter.dead_time_s
    assert margin.measured.startswith(f"with {added:.4g} µs of dead time the torque swings by"), (
        margin.measured
    )


def test_a_late_step_is_shown_with_the_time_that_is_allowed(steps: DutyRecord) -> None:
    late = with_column(steps, "torque", lambda torque: np.convolve(torque, np.ones(60) / 60.0)[: len(torque)])
    margin = judged("STP-1", late)
    assert margin is not None
    moment = deciding_moment(CHECKS["STP-1"], late, margin)
    assert moment.origin_s is not None
    assert moment.point is not None
    assert margin.measured.startswith(moment.point.words), margin.measured
    assert moment.start_s < moment.origin_s < moment.instants[0].value < moment.point.time_s <= moment.end_s
    assert moment.end_s - moment.start_s < 0.02, "milliseconds"


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [("second_duty", 1.2, "to 1.2"), ("first_duty", -0.1, "-0.1"), ("next_period", 2e-4, "changed by 100 %")],
)
def test_answers_outside_of_their_range_are_noticed(
    field: str, value: float, words: str, steps: DutyRecord
) -> None:
    margin = judged("DUT-1", with_command(steps, field, lambda values: np.full_like(values, value)))
    assert margin is not None
    assert not margin.met
    assert words in margin.measured


def test_a_wrong_estimate_of_the_torque_is_noticed_on_both_sides_of_its_limit(steps: DutyRecord) -> None:
    limit = steps.limits.estimate_error_nm
    for added, is_met in ((0.9 * limit, True), (1.1 * limit, False), (-1.1 * limit, False)):
        margin = judged("EST-1", with_command(steps, "torque", lambda torque, by=added: torque + by))
        assert margin is not None
        assert margin.met == is_met, margin.measured


def test_a_controller_without_an_estimate_of_the_torque_is_not_judged_by_it(
    steps: DutyRecord, sensed: DutyRecord
) -> None:
    assert judged("EST-1", with_command(steps, "torque", lambda torque: np.full_like(torque, np.nan))) is None
    assert judged("EST-1", sensed) is None, "what sensors with errors show is not the controller's doing"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (np.zeros_like, "not safe"),
        (lambda fault: np.where(np.arange(len(fault)) < 4100, 0, fault), "safe 110 ms after"),
        (np.ones_like, "before anything fails"),
    ],
    ids=["never", "late", "early"],
)
def test_a_safe_state_that_is_never_late_or_early_taken_is_noticed(
    change: Callable[[Any], Any], words: str, stuck: DutyRecord
) -> None:
    on = with_command(stuck, "first_leg", lambda legs: np.full_like(legs, LEG_PWM))
    margin = judged("SAF-1", with_command(on, "fault", change))
    assert margin is not None
    assert not margin.met
    assert words in margin.measured


def test_behind_a_lost_edge_a_drive_goes_on_or_is_safe(edge: DutyRecord) -> None:
    went_on = judged("SAF-1", edge)
    assert went_on is not None
    assert went_on.met
    assert "off its reference after lost-edge" in went_on.measured
    claimed = np.arange(len(edge.run.commands)) >= 3100
    stopped = with_column(edge, "torque", lambda torque: np.where(claimed, 0.0, torque))
    silent = judged("SAF-1", stopped)
    reported = judged("SAF-1", with_command(stopped, "fault", lambda _: claimed.astype(int)))
    assert silent is not None
    assert not silent.met, "without a word it is neither"
    assert reported is not None
    assert reported.met
    assert "safe 10 ms after lost-edge" in reported.measured


def test_a_lost_edge_is_judged_where_a_torque_is_asked_for(run: Run, interior: PmAcDocument) -> None:
    speed = interior.rating.base_speed_rpm
    turning = with_edges(speed_scenario(interior, (speed,), torque_nm=1.0), "hall", 1)
    assert judged("SAF-1", run(failing(turning, "lost-edge", 0.3))) is None


def test_a_failure_at_standstill_judges_nobody(run: Run, interior: PmAcDocument) -> None:
    held = torque_scenario(interior, 0.0, (torque_of(interior, 0.0, 0.5),))
    assert judged("SAF-1", run(failing(held, "open-phase", 0.3))) is None


def test_what_is_not_declared_is_not_judged(stuck: DutyRecord) -> None:
    assert judged("SAF-1", replace(stuck, declaration=Declaration(detects=("open-phase",)))) is None
    reason = CHECKS["SAF-1"].reason_not_applicable(Declaration(), stuck.document)
    assert reason is not None
    assert "does not declare" in reason


def test_ripple_that_modulation_or_dead_time_adds_is_noticed(slow: DutyRecord) -> None:
    unrest = 0.02 * np.where(np.arange(len(slow.run.commands)) % 4 < 2, 1.0, -1.0)
    uneven = with_command(slow, "first_duty", lambda ratio: ratio + unrest)
    alone = judged("RIP-4", uneven)
    assert alone is not None
    assert not alone.met, alone.measured
    other = slow.other_dead_time
    assert other is not None
    assert other.document.inverter.dead_time_s > 0.0 == slow.document.inverter.dead_time_s
    blanked = with_command(other, "first_duty", lambda ratio: ratio + unrest)
    both = judged("DTM-1", replace(slow, other_dead_time=blanked))
    assert both is not None
    assert not both.met, both.measured


def test_ripple_that_nobody_feels_is_always_allowed(slow: DutyRecord) -> None:
    unrest = 1e-5 * np.where(np.arange(len(slow.run.commands)) % 4 < 2, 1.0, -1.0)
    faint = with_command(slow, "first_duty", lambda ratio: ratio + unrest)
    rated = slow.document.rating.rated_power_w
    heavy = slow.document.replaced(rated_power_w=1e4 * rated, current_limit_a=1e4)
    assert judged("RIP-4", faint) is not None
    margins = judged("RIP-4", replace(faint, scenario=faint.scenario.replaced(drive=heavy)))
    assert margins is None, "less than 0.05 % of rated torque"


def test_a_swing_of_half_a_percent_of_rated_torque_is_always_allowed(slow: DutyRecord) -> None:
    unrest = 0.02 * np.where(np.arange(len(slow.run.commands)) % 4 < 2, 1.0, -1.0)
    swinging = with_command(slow, "first_duty", lambda ratio: ratio + unrest)
    for factor, is_met in ((1.0, False), (4.0, True)):
        power = factor * slow.document.rating.rated_power_w
        drive = slow.document.replaced(rated_power_w=power)
        margin = judged("RIP-4", replace(swinging, scenario=swinging.scenario.replaced(drive=drive)))
        assert margin is not None
        assert margin.met is is_met, f"{margin.measured}: 2.2 times the ideal, but little torque"


@pytest.mark.parametrize(
    ("low", "high", "is_judged"),
    [(1.0, 1.0, True), (0.9, 0.9, True), (0.6, 0.6, False), (0.4, 1.0, False), (0.0, 0.5, False)],
    ids=["on its reference", "just off it", "far off it", "falling", "stopping"],
)
def test_ripple_is_judged_while_the_speed_is_near_its_reference_alone(
    low: float, high: float, is_judged: bool, start: DutyRecord
) -> None:
    window = start.steady[-1]
    length = start.scenario.control_period_s
    rows = slice(round(window.start_s / length), round(window.end_s / length))

    def falling(speed: Any) -> Any:
        changed = speed.copy()
        changed[rows] = window.speed_reference * np.linspace(high, low, rows.stop - rows.start)
        return changed

    assert (judged("RIP-4", with_column(start, "speed", falling)) is not None) is is_judged


@pytest.fixture(scope="session")
def locking(run: Run, interior: PmAcDocument) -> DutyRecord:
    """Give a shaft that turns at base speed, and locks within a control period."""
    base = interior.rating.base_speed_rpm
    return run(failing(speed_scenario(interior, (base,), torque_nm=1.0), "locked-rotor", 0.3))


@pytest.mark.parametrize(
    ("periods", "is_judged"),
    [(-1, True), (0, False), (2, False), (13, False), (20, True)],
    ids=["before", "as it locks", "the first answer", "brought back", "later"],
)
def test_a_current_that_rises_as_the_shaft_locks_is_judged_once_it_can_be_brought_back(
    periods: int, is_judged: bool, locking: DutyRecord
) -> None:
    place = round(0.3 / locking.scenario.control_period_s) + periods

    def raised(peak: Any) -> Any:
        changed = peak.copy()
        changed[place] = 2.0 * locking.limits.peak_a
        return changed

    assert judged("OVC-1", locking) is not None
    margin = judged("OVC-1", with_column(locking, "peak_current", raised))
    assert margin is not None
    assert margin.met is not is_judged, margin.measured


def test_a_plant_with_less_inductance_has_more_ripple_that_is_allowed(
    run: Run, interior: PmAcDocument
) -> None:
    other = run(with_scales(speed_scenario(interior, (1000.0, 1500.0), torque_nm=0.8), inductance=0.5))
    limits = other.limits
    allowed = limits.peak_a + limits.peak_ripple_a
    for peak, is_met in ((0.999 * allowed, True), (1.001 * allowed, False)):
        margin = judged("OVC-1", with_column(other, "peak_current", lambda _, peak=peak: peak))
        assert margin is not None
        assert margin.met is is_met


def test_what_a_step_of_the_link_raises_a_current_before_an_answer_acts_is_allowed(
    run: Run, interior: PmAcDocument
) -> None:
    speed = interior.rating.base_speed_rpm
    held = torque_scenario(interior, speed, (torque_of(interior, speed, 0.5),))
    stepped = run(supply_step_scenario(held, interior, (1.0, 0.85, 1.0)))
    link, period = stepped.run.column("link"), stepped.scenario.control_period_s
    place = int(np.flatnonzero(np.diff(link) > 0.0)[-1]) + 1
    voltage = float(stepped.run.voltages[place - 1]) / link[place - 1] * (link[place] - link[place - 1])
    rise = voltage * period / interior.machine.direct_inductance_h
    assert rise > 0.01 * stepped.limits.peak_a
    for periods, share, is_met in ((0, 0.99, True), (2, 0.99, True), (0, 1.01, False), (30, 0.99, False)):

        def raised(peak: Any, at: int = place + periods, value: float = share * rise) -> Any:
            changed = peak.copy()
            changed[at] = stepped.limits.peak_a + value
            return changed

        margin = judged("OVC-1", with_column(stepped, "peak_current", raised))
        assert margin is not None
        assert margin.met is is_met, (periods, share, margin.measured)


def test_another_failure_excuses_no_current(stuck: DutyRecord) -> None:
    place = round(0.3 / stuck.scenario.control_period_s) + 2

    def raised(peak: Any) -> Any:
        changed = peak.copy()
        changed[place] = 2.0 * stuck.limits.peak_a
        return changed

    margin = judged("OVC-1", with_column(stuck, "peak_current", raised))
    assert margin is not None
    assert not margin.met


def test_the_sums_of_the_plant_and_of_the_current_are_judged(steps: DutyRecord) -> None:
    limit = steps.document.rating.current_limit_a
    high = judged("OVC-1", with_column(steps, "peak_current", lambda peak: peak + 1.21 * limit))
    missing = judged("PWR-1", replace(steps, run=replace(steps.run, worst_balance=2e-9)))
    shaft = steps.run.shaft.copy()
    shaft[shaft_ledger.WORST] = 2e-9
    driven = judged("PWR-1", replace(steps, run=replace(steps.run, shaft=shaft)))
    assert high is not None
    assert not high.met
    for margin in (missing, driven):
        assert margin is not None
        assert not margin.met


@pytest.mark.parametrize(
    ("name", "row", "met"),
    [("steps", 0, True), ("steps", 1, False), ("weakened", 100, True), ("weakened", 101, False)],
)
def test_current_that_is_not_the_doing_of_the_controller_is_not_judged(
    name: str, row: int, met: bool, request: pytest.FixtureRequest
) -> None:
    """The first answer acts in control period 1; at twice base speed the diodes conduct until then."""
    record = request.getfixturevalue(name)
    high = 10.0 * record.document.rating.current_limit_a
    spike = with_column(
        record, "peak_current", lambda peak: np.where(np.arange(len(peak)) == row, high, peak)
    )
    margin = judged("OVC-1", spike)
    assert margin is not None
    assert margin.met is met, margin.measured


@pytest.mark.parametrize(("factor", "met"), [(0.99, True), (1.009, True), (1.011, False)])
def test_steady_current_may_exceed_its_limit_by_one_percent(
    factor: float, met: bool, weakened: DutyRecord
) -> None:
    scaled = weakened
    for axis in ("direct", "quadrature"):
        scaled = with_column(scaled, axis, lambda current: factor * current)
    margin = judged("OVC-2", scaled)
    assert margin is not None
    assert margin.met is met, margin.measured


def test_steady_current_is_not_judged_where_no_current_within_the_limit_holds_the_voltage(
    weakened: DutyRecord,
) -> None:
    assert judged("OVC-2", with_column(weakened, "link", lambda link: 0.3 * link)) is None


def test_voltage_that_a_drive_lets_its_controller_reserve_is_no_lost_torque(weakened: DutyRecord) -> None:
    window = weakened.steady[1]
    full, required = (
        greatest_at(weakened.plant, window.speed, share * window.link).torque for share in (1.0, 0.96)
    )
    assert required < 0.97 * full

    def with_torque(record: DutyRecord, torque: float) -> bool:
        margin = judged("FWK-1", with_column(record, "torque", lambda values: np.full_like(values, torque)))
        assert margin is not None
        return margin.met

    assert with_torque(weakened, 0.951 * required)
    assert not with_torque(weakened, 0.949 * required)
    strict = weakened.document.replaced(weakening_voltage_percent=100.0)
    whole = replace(weakened, scenario=weakened.scenario.replaced(drive=strict))
    assert not with_torque(whole, 0.951 * required)


@pytest.mark.parametrize(("speed_rpm", "is_weakened"), [(1300.0, False), (1860.0, True)])
def test_braking_needs_less_voltage_and_so_less_weakening(
    run: Run, speed_rpm: float, is_weakened: bool
) -> None:
    """The voltage across the resistance adds to the back-EMF when motoring, and opposes it when braking."""
    drive = load_drive("pm-ac-2kw")
    assert isinstance(drive, PmAcDocument)
    record = run(torque_scenario(drive, speed_rpm, (0.0, -16.17)))
    braking = record.steady[-1]
    assert braking.torque == pytest.approx(-16.17, rel=0.001)
    # Less voltage than in use, and therefore more weakening, would be needless.
    used = max(braking.voltage, 0.9 * undistorted(record.plant, braking.link))
    least = least_free(record.plant, braking.speed, braking.torque, used).direct
    assert braking.direct == pytest.approx(least, abs=record.limits.direct_error_a)
    assert (braking.voltage > used * 0.999) is is_weakened
    margin = judged("MTP-1", record)
    if is_weakened:
        assert margin is None
    else:
        assert margin is not None
        assert margin.met, margin.measured


@pytest.mark.parametrize(("name", "speed_rpm"), [("pm-ac-2kw", -1629.0), ("pm-ac-msl", -1240.0)])
def test_lowering_a_load_near_the_voltage_limit_needs_no_weakening(
    run: Run, name: str, speed_rpm: float
) -> None:
    """Braking reserves voltage for the current regulators: hardly a tenth of it, for which nothing is weakened."""
    drive = load_drive(name).replaced(settling_s=0.3)
    assert isinstance(drive, PmAcDocument)
    record = run(hoist_scenario(drive, (speed_rpm,), 0.4 * drive.rating.rated_torque_nm))
    lowering = record.steady[-1]
    free = least_free(record.plant, lowering.speed, lowering.torque)
    assert 0.87 < free.voltage / undistorted(record.plant, lowering.link) < 0.9
    assert lowering.direct == pytest.approx(free.direct, abs=record.limits.direct_error_a)


def test_a_voltage_that_suffices_needs_no_weakening(run: Run) -> None:
    """Dead time gives voltage back while braking: the duty ratios stay below 90 %, which the currents alone exceed."""
    drive = load_drive("pm-ac-2kw").replaced(dead_time_s=5e-6)
    assert isinstance(drive, PmAcDocument)
    record = run(torque_scenario(drive, 1715.0, (0.0, -6.0)))
    braking = record.steady[-1]
    plant, share = record.plant, 0.9 * undistorted(record.plant, braking.link)
    free, within = (least_free(plant, braking.speed, braking.torque, voltage) for voltage in (1e9, share))
    assert braking.voltage < share < free.voltage
    assert within.direct < free.direct - record.limits.direct_error_a
    margin = judged("FWK-2", record)
    assert margin is not None
    assert margin.met, margin.measured


@pytest.mark.parametrize("speed_rpm", [1050.0, 1080.0])
def test_a_step_at_a_high_speed_leaves_the_current_along_the_magnet_alone(run: Run, speed_rpm: float) -> None:
    """Decoupling acts periods later, when less of the error is left; all of it moves the d current by over 10 %."""
    drive = load_drive("pm-ac-surface")
    assert isinstance(drive, PmAcDocument)
    margin = judged("DEC-1", run(torque_scenario(drive, speed_rpm, (2.0, 0.5))))
    assert margin is not None
    assert margin.value > 0.5, margin.measured


def test_a_step_is_decoupled_before_the_currents_have_moved(run: Run) -> None:
    """The field turns by 18 degrees in a control period; in the first ones hardly any of the error is gone."""
    drive = load_drive("pm-ac-interior").replaced(
        pole_pairs=37,
        resistance_ohm=0.371,
        direct_inductance_h=0.00746,
        quadrature_inductance_h=0.0215,
        magnet_flux_v_s=0.0192,
        link_voltage_v=80.7,
        carrier_frequency_hz=2760.0,
        carrier="double",
        base_speed_rpm=318.0,
        highest_speed_rpm=401.0,
        overspeed_rpm=457.0,
        rated_power_w=105.0,
        current_limit_a=2.86,
    )
    assert isinstance(drive, PmAcDocument)
    margin = judged("DEC-1", run(torque_scenario(drive, 450.0, (0.0, -0.5))))
    assert margin is not None
    assert margin.value > 0.5, margin.measured


def test_one_change_of_sign_of_a_legs_dead_time_and_drop_is_no_coupling(run: Run) -> None:
    """At a twelfth of the rated current all legs change sign; this moved the d current by 14 and 16 % of the step."""
    drive = load_drive("pm-ac-servo")
    assert isinstance(drive, PmAcDocument)
    for speed_rpm, torques in ((4990.0, (-0.0383, -0.2296)), (4750.0, (-0.0402, -0.201))):
        margin = judged("DEC-1", run(torque_scenario(drive, speed_rpm, torques)))
        assert margin is not None
        assert margin.met, margin.measured


def low_inductance_drive(inductance: float, frequency: float, link: float = 48.0) -> PmAcDocument:
    """Make a drive of 60 A whose base speed uses 60 % of the voltage, with all requirements left out."""
    drive = load_drive("pm-ac-surface")
    assert isinstance(drive, PmAcDocument)
    speed = 12000.0 if inductance < 5e-4 else 2000.0
    flux = 0.6 * link / 3.0**0.5 / (4 * speed * RADIANS_PER_RPM)
    return drive.replaced(
        pole_pairs=4,
        resistance_ohm=min(0.02, 200.0 * inductance),
        direct_inductance_h=inductance,
        quadrature_inductance_h=inductance,
        magnet_flux_v_s=flux,
        core_loss_conductance_s=0.0,
        inertia_kg_m2=1e-4,
        link_voltage_v=link,
        carrier_frequency_hz=frequency,
        base_speed_rpm=speed,
        highest_speed_rpm=1.1 * speed,
        overspeed_rpm=1.2 * speed,
        rated_power_w=0.5 * 6.0 * flux * 60.0 * speed * RADIANS_PER_RPM,
        current_limit_a=60.0,
        requirements={"settling_s": 0.05},
    )


@pytest.mark.parametrize("name", ["foc", "predictive-flux"])
@pytest.mark.parametrize(("inductance", "frequency"), [(1e-5, 50e3), (1e-4, 20e3), (1e-3, 10e3)])
def test_the_usual_rise_time_is_met_on_drives_with_low_inductance(
    inductance: float, frequency: float, name: str
) -> None:
    drive = low_inductance_drive(inductance, frequency)
    speed = 0.4 * drive.rating.base_speed_rpm
    shares = (0.0, 0.5, 0.3, 0.9, -0.3)
    steps = torque_scenario(drive, speed, [torque_of(drive, speed, share) for share in shares])
    loaded = own_candidate(resolve_candidate(name))
    margin = judged("STP-1", recorded(loaded, steps, loaded.controller()))
    assert margin is not None
    assert margin.met, margin.measured


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", ["foc", "predictive-flux", "direct-torque", "load-observer"])
def test_a_run_that_begins_at_speed_on_1_uh_stays_within_the_current_limit(name: str) -> None:
    drive = low_inductance_drive(1e-6, 50e3, link=24.0)
    speed = drive.rating.base_speed_rpm
    loaded = own_candidate(resolve_candidate(name))
    record = recorded(loaded, torque_scenario(drive, speed, (0.0,)), loaded.controller())
    margin = judged("OVC-1", record)
    assert margin is not None
    assert margin.met, margin.measured


@pytest.mark.parametrize(("braking", "met"), [(0.15, True), (0.35, False)])
def test_braking_after_a_large_step_is_measured_by_the_step(
    run: Run, interior: PmAcDocument, braking: float, met: bool
) -> None:
    weak = interior.replaced(rated_power_w=200.0)
    speed = 1.05 * weak.rating.base_speed_rpm
    record = run(torque_scenario(weak, speed, (torque_of(weak, speed, 2.5), 0.0)))
    rated = record.document.rating.rated_torque_nm
    half = len(record.run.trace) // 2
    braked = with_column(
        record,
        "torque",
        lambda torque: np.where(np.arange(len(torque)) == half + 20, -braking * rated, np.abs(torque)),
    )
    margin = judged("FWK-3", braked)
    assert margin is not None
    assert margin.met is met, margin.measured


def test_a_plant_that_differs_is_judged_by_its_own_check_alone(run: Run, interior: PmAcDocument) -> None:
    speed = 0.5 * interior.rating.base_speed_rpm
    plain = torque_scenario(interior, speed, (0.0, torque_of(interior, speed, 0.5)))
    record = run(with_scales(plain, emf_constant=0.8))
    named = {check for check in CHECKS if judged(check, record) is not None}
    assert named == {"PWR-1", "DUT-1", "OVC-1"}, "the torque of weaker magnets is no fault of the controller"


def test_loss_is_judged_at_the_efficiency_points_alone(run: Run, interior: PmAcDocument) -> None:
    rated = torque_of(interior, 0.0, 1.0)
    base = interior.rating.base_speed_rpm
    at_point = run(torque_scenario(interior, base, (0.5 * rated,)))
    beside = run(torque_scenario(interior, 0.9 * base, (0.5 * rated,)))
    margin = judged("EFF-1", at_point)
    assert margin is not None
    assert judged("EFF-1", beside) is None
    worse = judged("EFF-1", with_column(at_point, "direct", lambda direct: direct + 1.5))
    assert worse is not None
    assert not worse.met


def test_the_oracle_leaves_no_more_torque_than_the_limits(interior: PmAcDocument) -> None:
    plant = interior.plant()
    best = greatest_at(plant, 400.0, plant.link_voltage)
    assert best.voltage <= plant.link_voltage / 3.0**0.5 * (1.0 + 1e-9)
    assert least_free(plant, 400.0, best.torque).current <= best.current


def test_the_texts_state_the_numbers_of_the_drive(interior: PmAcDocument) -> None:
    strict = interior.replaced(torque_tolerance_percent=1.0, overshoot_percent=5.0)
    assert "overshoot 5 %" in on_drive(CHECKS["STP-1"], strict).limit
    assert on_drive(CHECKS["ACC-1"], strict).limit != on_drive(CHECKS["ACC-1"], interior).limit
    for check in CHECKS.values():
        assert "{" not in on_drive(check, interior).limit


@pytest.mark.parametrize(
    "keys",
    [
        {"encoder_error_deg": 40.0},
        # Where no shunt ever sees a current, the regulators integrate until nothing is left.
        {"shunts": "low-side", "settling_s": 9e-5},
        {"current_gain_spread": 0.3},
    ],
    ids=["alignment", "blind shunts", "gains"],
)
def test_sensors_too_bad_for_any_controller_fail(
    run: Run, interior: PmAcDocument, keys: dict[str, Any]
) -> None:
    margin = judged("ROB-5", run(through(interior, **keys)))
    assert margin is not None
    assert not margin.met, margin.measured


@pytest.mark.parametrize("shunts", ["in-line", "low-side", "link"])
@pytest.mark.parametrize("position", ["exact", "encoder", "hall"])
def test_sensors_without_errors_show_the_plant_as_it_is(
    run: Run, interior: PmAcDocument, shunts: str, position: str
) -> None:
    keys: dict[str, Any] = {"current_gain_spread": 0.0, "current_offset_a": 0.0, "current_noise_a": 0.0}
    keys |= {"voltage_noise_v": 0.0, "converter_bits": 24, "shunts": shunts, "position": position}
    without_errors = {
        "encoder": {"encoder_lines": 100_000},
        "hall": {"placement_error_deg": 0.0, "hysteresis_deg": 0.0},
        "exact": {},
    }
    record = run(through(interior, **keys, **without_errors[position]))
    ideal = run(through(interior).replaced(sensors="ideal"))
    for seen, true in zip(record.steady, ideal.steady, strict=True):
        assert seen.torque == pytest.approx(true.torque, rel=5e-3)
        assert np.hypot(seen.direct, seen.quadrature) == pytest.approx(
            np.hypot(true.direct, true.quadrature), rel=5e-3
        )
