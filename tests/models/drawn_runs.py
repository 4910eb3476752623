"""Runs of any plant, drawn or made of edges, and what they sum up to, so that energy can be seen to close."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

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
GRAZED = [(0.0, 0.0), (0.0, 10.0), (0.25, 0.25), (2.0, 1.0), (0.25, 26.0), (0.25, 0.0)]
"""Bands and references (A) whose levels touch each other, zero, or the current limit of a drive."""


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

    drive: Any
    angle: float
    currents: tuple[float, ...]
    periods: tuple[Period, ...]


@dataclass
class Account:
    """What a run sums up to, and how far its energy is from closing, over the throughput."""

    totals: np.ndarray
    shaft: float = 0.0
    throughput: float = 0.0
    growth: float = 0.0
    statuses: list[int] = field(default_factory=list)
    currents: list[np.ndarray] = field(default_factory=list)

    @property
    def origin_error(self) -> float:
        """How far the energy of both halves is from exchanged less twice returned."""
        totals = self.totals
        net = totals[ledger.EXCHANGED] - 2.0 * totals[ledger.RETURNED]
        return self.share(totals[ledger.UPPER] + totals[ledger.LOWER] - net)

    def use_error(self, resistance: float) -> float:
        """Return how far the energy of both halves is from where it went."""
        totals = self.totals
        used = resistance * totals[ledger.SQUARE] + self.shaft + totals[ledger.DEVICE] + self.growth
        return self.share(totals[ledger.UPPER] + totals[ledger.LOWER] - used)

    def share(self, energy: float) -> float:
        """Return an energy over the throughput."""
        return float(max(abs(energy) - UNDERFLOW, 0.0) / (self.throughput + UNDERFLOW))


def drawn(examples: int) -> settings:
    """Return the settings of a test that looks at so many drawn runs, the same ones each time.

    Where the environment variable `DRAWN_RUNS` has a number, it looks at that many.
    """
    return settings(
        max_examples=int(os.environ.get("DRAWN_RUNS", examples)),
        derandomize=True,
        database=None,
        suppress_health_check=list(HealthCheck),
    )


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_infinity=False)


@st.composite
def runs(
    draw: st.DrawFn,
    make_drive: Callable[..., Any],
    *,
    phases: st.SearchStrategy[int],
    flats: Sequence[float],
    windows: Sequence[float],
    references: Sequence[float] = (),
    advances: Sequence[float] = (),
    to_window_edges: bool = False,
    further: Mapping[str, st.SearchStrategy[Any]] | None = None,
) -> Run:
    """Draw a run; the machine is scaled to its supply, so that every mode is within reach.

    Flats and windows (°), references (A), advances (rad) and further constants are those that matter to one kind.
    """
    count = draw(phases)
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
    flat = draw(st.one_of(numbers(0.0, 179.0), st.sampled_from([0.0, *flats])))
    window = draw(st.one_of(numbers(1.0, 180.0), st.sampled_from([*windows, 180.0])))
    angles, values = trapezoid_corners(math.radians(flat))
    drops = st.one_of(st.just(0.0), numbers(0.0, 0.1 * supply))
    drive = make_drive(
        phases=count,
        pole_pairs=pole_pairs,
        **{name: draw(strategy) for name, strategy in (further or {}).items()},
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
    # At base speed the peak of the EMF, of a phase or between two, lies exactly on the voltage that it works against.
    speeds = st.one_of(
        numbers(0.0, 2.5).map(lambda factor: factor * base_speed),
        st.sampled_from([base_speed, 0.0, 1e-12, 1e-6, 0.5 * base_speed]),
    )
    halves = st.one_of(st.just(supply), numbers(0.6 * supply, 1.3 * supply))
    period = st.builds(
        Period,
        speed=speeds,
        reference=st.one_of(numbers(0.0, current), st.sampled_from([0.0, *references, band, current])),
        advance=st.one_of(numbers(0.0, 0.5 * math.pi), st.sampled_from([0.0, *advances, 0.5 * math.pi])),
        upper=halves,
        lower=halves,
        duration=st.just(duration),
        to_window_edge=st.booleans() if to_window_edges else st.just(False),
    )
    periods = draw(st.lists(period, min_size=1, max_size=6))
    currents = draw(
        st.one_of(st.just((0.0,) * count), st.tuples(*[numbers(-1.5 * current, 1.5 * current)] * count))
    )
    angle = draw(st.one_of(numbers(-20.0, 20.0), st.sampled_from([0.0, math.pi, 0.5 * math.pi])))
    return Run(drive, angle, currents, tuple(periods))


def reference_machine(flat_deg: float) -> dict[str, Any]:
    """Return the constants that the reference machine has whatever the connection of its phases."""
    angles, values = trapezoid_corners(math.radians(flat_deg))
    return {
        "pole_pairs": 11,
        "emf_constant": 0.339,
        "emf_angles": angles,
        "emf_values": values,
        "half_supply_voltage": 48.0,
    }


def grazing(drive: Any, reference: float, duration: float | None, *, to_window_edge: bool) -> Run:
    """Return a run over two cycles in which the EMF touches the supply and the advance angle jumps.

    Without a duration, periods are whole parts of a cycle, so that every end of one is a corner or an edge.
    """
    supply = drive.half_supply_voltage
    speed = supply / drive.emf_constant
    if duration is None:
        duration = 2.0 * math.pi / (12.0 * drive.pole_pairs * speed)
    periods = tuple(
        Period(
            speed,
            reference,
            0.0 if k % 3 else 0.5 * math.pi,
            supply,
            supply,
            duration,
            to_window_edge=to_window_edge and k % 2 == 0,
        )
        for k in range(24)
    )
    return Run(drive, 0.0, (0.0,) * drive.phases, periods)


def _duration(drive: Any, period: Period, angle: float) -> float:
    """Return the period's length, cut so that it ends on the first phase's next window edge where requested."""
    electrical = drive.pole_pairs * period.speed
    if not period.to_window_edge or electrical <= 0.0:
        return period.duration
    from_start = (angle + period.advance - 0.5 * (math.pi - drive.window)) % math.pi
    to_edge = drive.window - from_start if from_start < drive.window else math.pi - from_start
    return float(min(period.duration, to_edge / electrical))


def account_of(run: Run, make_phases: Callable[..., Any], advance_phases: Callable[..., int]) -> Account:
    """Return what a run sums up to on a plant."""
    drive = run.drive
    phases = make_phases(drive)
    phases.currents[:] = run.currents
    before = stored_energy(drive, phases.currents)
    account = Account(np.zeros(ledger.ENTRIES), throughput=before)
    angle = run.angle
    for period in run.periods:
        totals = np.zeros(ledger.ENTRIES)
        duration = _duration(drive, period, angle)
        status = advance_phases(
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
        account.statuses.append(status)
        account.currents.append(phases.currents.copy())
        angle += drive.pole_pairs * period.speed * duration
        shaft = period.speed * totals[ledger.IMPULSE]
        account.totals += totals
        account.shaft += shaft
        account.throughput += totals[ledger.EXCHANGED] + abs(shaft) + stored_energy(drive, phases.currents)
    account.growth = stored_energy(drive, phases.currents) - before
    return account


def check_energy(run: Run, account: Account) -> None:
    """Check that a run came to its end, that its energy closes, and that no loss is less than none."""
    totals = account.totals
    assert account.statuses == [COMPLETED] * len(run.periods), f"statuses are {account.statuses}"
    assert np.all(np.isfinite(totals)), f"a total is not finite: {totals}"
    assert np.all(np.isfinite(account.currents)), f"currents are {account.currents}"
    assert account.origin_error <= CLOSURE, f"exchanged less twice returned: {account.origin_error:.1e}"
    missing = account.use_error(run.drive.resistance)
    assert missing <= CLOSURE, f"energy that arrives: {missing:.1e} of the throughput is missing"
    for name, entry in LOSSES.items():
        assert totals[entry] >= -1e-12 * account.throughput - UNDERFLOW, (
            f"{name} is negative: {totals[entry]!r}"
        )
