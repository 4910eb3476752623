"""Energy and charge close for any star and any command, and no event is awaited for ever."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED, TOO_MANY_EVENTS
from drivegate_models.machine.emf import trapezoid_corners
from drivegate_models.machine.ledger import stored_energy
from drivegate_models.star.plant.drive import (
    EVERY_HALF,
    ON_PWM,
    PWM_ON,
    UPPER_ONLY,
    StarDrive,
    make_star_drive,
)
from drivegate_models.star.plant.phases import advance_phases, make_phases

CLOSURE = 1e-9
"""Greatest part of the throughput that may be missing."""
NEUTRAL = 1e-12
"""Greatest sum of the phase currents, over their magnitudes."""
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
    max_examples=300,
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


@dataclass(frozen=True)
class Run:
    """A drive, where it starts, and its periods."""

    drive: StarDrive
    angle: float
    currents: tuple[float, ...]
    periods: tuple[Period, ...]


@dataclass
class Account:
    """What a run sums up to, and the worst of what has to vanish, each over its scale."""

    totals: np.ndarray
    shaft: float = 0.0
    throughput: float = 0.0
    growth: float = 0.0
    neutral: float = 0.0
    completed: bool = True

    @property
    def origin_error(self) -> float:
        """How far the energy of both halves is from exchanged less twice returned."""
        totals = self.totals
        net = totals[ledger.EXCHANGED] - 2.0 * totals[ledger.RETURNED]
        return float(self._share(totals[ledger.UPPER] + totals[ledger.LOWER] - net))

    @property
    def charge_error(self) -> float:
        """How far the halves are from giving the same."""
        return float(self._share(self.totals[ledger.UPPER] - self.totals[ledger.LOWER]))

    def use_error(self, resistance: float) -> float:
        """Return how far the energy of both halves is from where it went."""
        totals = self.totals
        used = resistance * totals[ledger.SQUARE] + self.shaft + totals[ledger.DEVICE] + self.growth
        return float(self._share(totals[ledger.UPPER] + totals[ledger.LOWER] - used))

    def _share(self, energy: float) -> float:
        return max(abs(energy) - UNDERFLOW, 0.0) / (self.throughput + UNDERFLOW)


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_infinity=False)


@st.composite
def runs(draw: st.DrawFn) -> Run:
    """Draw a run; the machine is scaled to its supply, so that every mode is within reach."""
    phases = draw(st.sampled_from([3, 3, 3, 5, 7, 9]))
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
    flat = draw(st.one_of(numbers(0.0, 179.0), st.sampled_from([0.0, 60.0, 120.0, 150.0])))
    window = draw(st.one_of(numbers(1.0, 180.0), st.sampled_from([60.0, 120.0, 150.0, 180.0])))
    angles, values = trapezoid_corners(math.radians(flat))
    drops = st.one_of(st.just(0.0), numbers(0.0, 0.1 * supply))
    drive = make_star_drive(
        phases=phases,
        pole_pairs=pole_pairs,
        regulation=draw(st.sampled_from([EVERY_HALF, EVERY_HALF, UPPER_ONLY, PWM_ON, ON_PWM])),
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
    # At base speed the line EMF lies exactly on the link's voltage.
    speeds = st.one_of(
        numbers(0.0, 2.5).map(lambda factor: factor * base_speed),
        st.sampled_from([base_speed, 0.0, 1e-12, 1e-6, 0.5 * base_speed]),
    )
    references = st.one_of(numbers(0.0, current), st.sampled_from([0.0, 1e-9, band, current]))
    advances = st.one_of(numbers(0.0, 0.5 * math.pi), st.sampled_from([0.0, math.pi / 6.0, 0.5 * math.pi]))
    halves = st.one_of(st.just(supply), numbers(0.6 * supply, 1.3 * supply))
    period = st.builds(
        Period,
        speed=speeds,
        reference=references,
        advance=advances,
        upper=halves,
        lower=halves,
        duration=st.just(duration),
    )
    periods = draw(st.lists(period, min_size=1, max_size=6))
    currents = draw(
        st.one_of(st.just((0.0,) * phases), st.tuples(*[numbers(-1.5 * current, 1.5 * current)] * phases))
    )
    mean = sum(currents) / phases
    balanced = [value - mean for value in currents[1:]]
    angle = draw(st.one_of(numbers(-20.0, 20.0), st.sampled_from([0.0, math.pi, 0.5 * math.pi])))
    return Run(drive, angle, (-math.fsum(balanced), *balanced), tuple(periods))


def account_of(run: Run) -> Account:
    """Return what a run sums up to."""
    drive = run.drive
    phases = make_phases(drive)
    phases.currents[:] = run.currents
    before = stored_energy(drive, phases.currents)
    account = Account(np.zeros(ledger.ENTRIES))
    angle = run.angle
    for period in run.periods:
        totals = np.zeros(ledger.ENTRIES)
        status = advance_phases(
            drive,
            phases,
            angle,
            period.speed,
            period.upper,
            period.lower,
            period.reference,
            period.advance,
            period.duration,
            totals,
        )
        account.completed = account.completed and status == COMPLETED
        angle += drive.pole_pairs * period.speed * period.duration
        shaft = period.speed * totals[ledger.IMPULSE]
        account.totals += totals
        account.shaft += shaft
        stored = stored_energy(drive, phases.currents)
        account.throughput += totals[ledger.EXCHANGED] + abs(shaft) + stored
        size = float(np.sum(np.abs(phases.currents)))
        if size > 0.0:
            account.neutral = max(account.neutral, abs(math.fsum(phases.currents)) / size)
    account.growth = stored_energy(drive, phases.currents) - before
    account.throughput += before
    return account


def check(run: Run) -> None:
    account = account_of(run)
    totals = account.totals
    assert account.completed, "an advance has too many events"
    assert np.all(np.isfinite(totals)), f"a total is not finite: {totals}"
    assert account.origin_error <= CLOSURE, f"exchanged less twice returned: {account.origin_error:.1e}"
    assert account.use_error(run.drive.resistance) <= CLOSURE, (
        f"energy that arrives: {account.use_error(run.drive.resistance):.1e} of the throughput is missing"
    )
    assert account.charge_error <= CLOSURE, f"the halves differ by {account.charge_error:.1e}"
    assert account.neutral <= NEUTRAL, f"the currents sum to {account.neutral:.1e} of their magnitudes"
    for name, entry in LOSSES.items():
        assert totals[entry] >= -1e-12 * account.throughput - UNDERFLOW, (
            f"{name} is negative: {totals[entry]!r}"
        )


@pytest.mark.kernel
@drawn
@given(runs())
def test_energy_and_charge_close_for_drawn_stars(run: Run) -> None:
    check(run)


REFERENCE = {
    "phases": 3,
    "pole_pairs": 11,
    "resistance": 0.048,
    "inductance": 1.728e-3,
    "emf_constant": 0.339,
    "emf_angles": trapezoid_corners(math.radians(120.0))[0],
    "emf_values": trapezoid_corners(math.radians(120.0))[1],
    "half_supply_voltage": 48.0,
    "current_limit": 130.0 / 3.0,
}


def _grazing(band: float, reference: float, window_deg: float, resistance: float, regulation: int) -> Run:
    """Return a run over two cycles in which the line EMF touches the link and the advance angle jumps."""
    drive = make_star_drive(
        **REFERENCE
        | {
            "hysteresis_band": band,
            "window": math.radians(window_deg),
            "resistance": resistance,
            "regulation": regulation,
        }
    )
    speed = 48.0 / 0.339
    # Whole parts of a cycle, so that every end of a period is a corner or an edge.
    duration = 2.0 * math.pi / (12.0 * 11 * speed)
    periods = tuple(
        Period(speed, reference, 0.0 if k % 3 else 0.5 * math.pi, 48.0, 48.0, duration) for k in range(24)
    )
    return Run(drive, 0.0, (0.0,) * 3, periods)


GRAZING = [
    _grazing(band, reference, window_deg, resistance, regulation)
    for band, reference in [(0.0, 0.0), (0.0, 10.0), (0.25, 0.25), (2.0, 1.0), (0.25, 26.0), (0.25, 0.0)]
    for window_deg in (60.0, 120.0, 180.0)
    for resistance in (0.0, 0.048)
    for regulation in (EVERY_HALF, UPPER_ONLY, PWM_ON)
]


@pytest.mark.kernel
@pytest.mark.parametrize("run", GRAZING)
def test_energy_closes_where_events_coincide(run: Run) -> None:
    check(run)


@pytest.mark.kernel
@pytest.mark.parametrize("regulation", [EVERY_HALF, UPPER_ONLY, PWM_ON, ON_PWM])
def test_rounding_at_a_tiny_reference_costs_no_energy(regulation: int) -> None:
    """A snapping distance in amperes would swallow such currents whole."""
    drive = make_star_drive(
        **REFERENCE, window=math.radians(120.0), hysteresis_band=0.0, regulation=regulation
    )
    periods = tuple(Period(60.0, 3e-9, 0.3, 48.0, 48.0, 5e-4) for _ in range(40))
    check(Run(drive, 0.0, (0.0,) * 3, periods))


def test_a_band_that_no_current_can_rest_in_is_given_up() -> None:
    drive = make_star_drive(**REFERENCE, window=math.radians(120.0), hysteresis_band=1e-10)
    totals = np.zeros(ledger.ENTRIES)
    status = advance_phases(drive, make_phases(drive), 0.0, 50.0, 48.0, 48.0, 20.0, 0.0, 5e-3, totals)
    assert status == TOO_MANY_EVENTS
