"""Energy closes for any machine and any command, and nothing dissipates less than nothing."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivegate_models.half_bridge.plant.drive import Drive, make_drive
from drivegate_models.half_bridge.plant.phases import Phases, advance_phases, make_phases
from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.machine.emf import trapezoid_corners
from drivegate_models.machine.ledger import stored_energy

CLOSURE = 1e-9
"""Greatest part of the throughput that may be missing."""
UNDERFLOW = 1e-250
"""Energy (J) below which products of currents have no digits left."""

LOSSES = {
    "copper": ledger.SQUARE,
    "forward drops": ledger.DEVICE,
    "switching": ledger.SWITCHING,
    "core loss from the supply": ledger.CORE_SOURCE,
    "core loss from the shaft": ledger.CORE_DRAG_IMPULSE,
    "returned energy": ledger.RETURNED,
    "current magnitude": ledger.MAGNITUDE,
}

drawn = settings(
    max_examples=250,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=list(HealthCheck),
)


@dataclass(frozen=True)
class Period:
    """What is constant during one control period."""

    speed: float
    reference: float
    advance: float
    upper: float
    lower: float
    duration: float
    to_window_edge: bool = False


@dataclass(frozen=True)
class Run:
    """A drive, where it starts, and its periods."""

    drive: Drive
    angle: float
    currents: tuple[float, ...]
    periods: tuple[Period, ...]


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_infinity=False)


@st.composite
def runs(draw: st.DrawFn) -> Run:
    """Draw a run; the machine is scaled to its supply, so that every mode is within reach."""
    phases = draw(st.integers(1, 9))
    pole_pairs = draw(st.integers(1, 30))
    supply = draw(st.sampled_from([48.0, 12.0, 310.5]))
    current = draw(st.sampled_from([26.0, 2.0, 350.0]))
    duration = draw(st.sampled_from([5e-4, 1e-4, 3.3e-4, 2e-3]))
    # How much of `current` the supply builds up in one period, and how long a current lasts.
    inductance = supply * duration / (current * draw(numbers(0.02, 5.0)))
    resistance = draw(st.one_of(st.just(0.0), numbers(1e-6, 30.0))) * inductance / (10.0 * duration)
    chops = draw(st.one_of(st.just(0.0), numbers(0.2, 30.0)))
    band = supply * duration / (inductance * chops) if chops else 0.0
    base_speed = draw(st.sampled_from([50.0, 157.0, 300.0]))
    flat = draw(st.one_of(numbers(0.0, 179.0), st.sampled_from([0.0, 98.0])))
    window = draw(st.one_of(numbers(1.0, 180.0), st.sampled_from([144.0, 180.0])))
    angles, values = trapezoid_corners(math.radians(flat))
    drops = st.one_of(st.just(0.0), numbers(0.0, 0.1 * supply))
    drive = make_drive(
        phases=phases,
        pole_pairs=pole_pairs,
        resistance=resistance,
        inductance=inductance,
        emf_constant=supply / base_speed,
        emf_angles=angles,
        emf_values=values,
        half_supply_voltage=supply,
        hysteresis_band=band,
        window=math.radians(window),
        current_limit=current,
        core_loss_conductance=draw(st.sampled_from([0.0, 3e-3])),
        switch_drop=draw(drops),
        diode_drop=draw(drops),
        turn_on_energy=draw(st.sampled_from([0.0, 1e-4])),
        turn_off_energy=draw(st.sampled_from([0.0, 2e-4])),
    )
    # At base speed the peak of the back-EMF lies exactly on the rail.
    speeds = st.one_of(
        numbers(0.0, 2.5).map(lambda factor: factor * base_speed),
        st.sampled_from([base_speed, 0.0, 1e-12, 1e-6, 0.5 * base_speed]),
    )
    references = st.one_of(numbers(0.0, current), st.sampled_from([0.0, band, current]))
    advances = st.one_of(numbers(0.0, 0.5 * math.pi), st.sampled_from([0.0, 0.5 * math.pi]))
    halves = st.one_of(st.just(supply), numbers(0.6 * supply, 1.3 * supply))
    periods = draw(
        st.lists(
            st.builds(
                Period,
                speed=speeds,
                reference=references,
                advance=advances,
                upper=halves,
                lower=halves,
                duration=st.just(duration),
                to_window_edge=st.booleans(),
            ),
            min_size=1,
            max_size=6,
        )
    )
    currents = draw(
        st.one_of(st.just((0.0,) * phases), st.tuples(*[numbers(-1.5 * current, 1.5 * current)] * phases))
    )
    angle = draw(st.one_of(numbers(-20.0, 20.0), st.sampled_from([0.0, math.pi, 0.5 * math.pi])))
    return Run(drive, angle, currents, tuple(periods))


def _duration(drive: Drive, period: Period, angle: float) -> float:
    """Return the period's length, cut so that it ends on the first phase's next window edge where requested."""
    electrical = drive.pole_pairs * period.speed
    if not period.to_window_edge or electrical <= 0.0:
        return period.duration
    from_start = (angle + period.advance - 0.5 * (math.pi - drive.window)) % math.pi
    to_edge = drive.window - from_start if from_start < drive.window else math.pi - from_start
    return min(period.duration, to_edge / electrical)


@dataclass
class Account:
    """What a whole run sums up to."""

    totals: np.ndarray
    shaft: float
    throughput: float
    stored_before: float
    stored_after: float
    statuses: list[int]
    phases: Phases


def _run(run: Run) -> Account:
    drive = run.drive
    phases = make_phases(drive)
    phases.currents[:] = run.currents
    stored = stored_energy(drive, phases.currents)
    account = Account(np.zeros(ledger.ENTRIES), 0.0, stored, stored, 0.0, [], phases)
    angle = run.angle
    for period in run.periods:
        totals = np.zeros(ledger.ENTRIES)
        duration = _duration(drive, period, angle)
        account.statuses.append(
            advance_phases(
                drive,
                phases,
                angle,
                period.speed,
                period.upper,
                period.lower,
                period.reference,
                period.advance,
                duration,
                totals,
            )
        )
        angle += drive.pole_pairs * period.speed * duration
        shaft = period.speed * totals[ledger.IMPULSE]
        account.totals += totals
        account.shaft += shaft
        account.throughput += totals[ledger.EXCHANGED] + abs(shaft) + stored_energy(drive, phases.currents)
    account.stored_after = stored_energy(drive, phases.currents)
    return account


REFERENCE = {
    "phases": 5,
    "pole_pairs": 11,
    "resistance": 0.08,
    "inductance": 2.88e-3,
    "emf_constant": 0.339,
    "emf_angles": trapezoid_corners(math.radians(98.0))[0],
    "emf_values": trapezoid_corners(math.radians(98.0))[1],
    "half_supply_voltage": 48.0,
    "current_limit": 26.0,
}


def _grazing(band: float, reference: float, window_deg: float, *, resistance: float = 0.08) -> Run:
    """Return a run over two cycles in which the back-EMF touches the rail and the advance angle jumps."""
    drive = make_drive(
        **REFERENCE | {"hysteresis_band": band, "window": math.radians(window_deg), "resistance": resistance}
    )
    speed = 48.0 / 0.339
    periods = tuple(
        Period(speed, reference, 0.0 if k % 3 else 0.5 * math.pi, 48.0, 48.0, 5e-4, to_window_edge=k % 2 == 0)
        for k in range(24)
    )
    return Run(drive, 0.0, (0.0,) * 5, periods)


GRAZING = [
    _grazing(band, reference, window_deg, resistance=resistance)
    for band, reference in [(0.0, 0.0), (0.0, 10.0), (0.25, 0.25), (2.0, 1.0), (0.25, 26.0), (0.25, 0.0)]
    for window_deg in (144.0, 180.0)
    for resistance in (0.0, 0.08)
]


def _check(run: Run) -> None:
    account = _run(run)
    totals = account.totals
    assert account.statuses == [COMPLETED] * len(run.periods), f"statuses are {account.statuses}"
    assert np.all(np.isfinite(totals)), f"a total is not finite: {totals}"
    assert np.all(np.isfinite(account.phases.currents)), f"currents are {account.phases.currents}"

    allowed = CLOSURE * account.throughput + UNDERFLOW
    supplied = totals[ledger.UPPER] + totals[ledger.LOWER]
    origin = totals[ledger.EXCHANGED] - 2.0 * totals[ledger.RETURNED]
    assert abs(supplied - origin) <= allowed, (
        f"the half-sources give {supplied!r} J, exchanged less twice returned is {origin!r} J"
    )
    copper = run.drive.resistance * totals[ledger.SQUARE]
    growth = account.stored_after - account.stored_before
    used = copper + account.shaft + totals[ledger.DEVICE] + growth
    assert abs(supplied - used) <= allowed, (
        f"the half-sources give {supplied!r} J, {used!r} J arrive; throughput {account.throughput!r} J"
    )

    for name, entry in LOSSES.items():
        assert totals[entry] >= -1e-12 * account.throughput - UNDERFLOW, (
            f"{name} is negative: {totals[entry]!r}"
        )
    assert totals[ledger.RETURNED] <= totals[ledger.EXCHANGED] * (1.0 + 1e-12) + UNDERFLOW, (
        "more comes back than was exchanged"
    )


@pytest.mark.kernel
@drawn
@given(runs())
def test_energy_closes_for_drawn_machines(run: Run) -> None:
    _check(run)


@pytest.mark.kernel
@pytest.mark.parametrize("run", GRAZING)
def test_energy_closes_where_events_coincide(run: Run) -> None:
    _check(run)


@pytest.mark.kernel
@drawn
@given(runs(), numbers(0.0, 0.999))
def test_blocked_currents_decay_and_never_reverse(run: Run, share: float) -> None:
    """With the gates blocked and the back-EMF below the rails, a diode can only let a current die."""
    drive = run.drive
    phases = make_phases(drive)
    phases.currents[:] = run.currents
    totals = np.zeros(ledger.ENTRIES)
    angle = run.angle
    for period in run.periods:
        before = phases.currents.copy()
        rail = min(period.upper, period.lower) + drive.diode_drop
        speed = share * min(period.speed, rail / drive.emf_constant)
        advance_phases(
            drive,
            phases,
            angle,
            speed,
            period.upper,
            period.lower,
            0.0,
            period.advance,
            period.duration,
            totals,
        )
        angle += drive.pole_pairs * speed * period.duration
        after = phases.currents
        assert np.all(np.abs(after) <= np.abs(before)), f"a current grew from {before} to {after}"
        assert np.all(before * after >= 0.0), f"a current reversed from {before} to {after}"
    assert totals[ledger.SWITCHING] == 0.0, "blocked gates cannot switch"


@pytest.mark.kernel
@drawn
@given(runs())
def test_the_current_stays_inside_the_band_while_the_rail_can_turn_it(run: Run) -> None:
    """Where a regulator that starts from rest has control throughout, no current passes i* + h."""
    drive = run.drive
    phases = make_phases(drive)
    totals = np.zeros(ledger.ENTRIES)
    angle = run.angle
    reference = max((period.reference for period in run.periods), default=0.0)
    for period in run.periods:
        speed = min(period.speed, 0.9 * min(period.upper, period.lower) / drive.emf_constant)
        advance_phases(
            drive,
            phases,
            angle,
            speed,
            period.upper,
            period.lower,
            reference,
            period.advance,
            period.duration,
            totals,
        )
        angle += drive.pole_pairs * speed * period.duration
    highest = reference + drive.hysteresis_band if reference > 0.0 else 0.0
    assert totals[ledger.PEAK] <= highest * (1.0 + 1e-12), (
        f"a current reached {totals[ledger.PEAK]!r} A; the band ends at {highest!r} A"
    )
