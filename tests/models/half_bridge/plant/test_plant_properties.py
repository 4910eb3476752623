"""What must hold for any machine: symmetry, scaling, and the same answer on every way to it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from drivegate_models.half_bridge.periodic import periodic_start
from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.half_bridge.plant.phases import Phases, advance_phases, make_phases
from drivegate_models.machine import ledger, segments
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.machine.period import PERIODIC
from drivegate_models.machine.torque import torque_extremes
from drivegate_models.steady.steady_state import (
    KEPT_TIME,
    SteadyState,
    advance_with_extremes,
    cycles_from_rest,
    steady_state,
)

SUPPLY = 48.0

Motor = Callable[..., Drive]
drawn = settings(
    max_examples=150,
    derandomize=True,
    database=None,
    suppress_health_check=list(HealthCheck),
)


class Point(NamedTuple):
    """An operating point: rpm, degrees, amperes."""

    rpm: float
    advance_deg: float
    reference: float

    @property
    def speed(self) -> float:
        return self.rpm * math.pi / 30.0

    @property
    def advance(self) -> float:
        return math.radians(self.advance_deg)


# Floats, since a kernel is compiled again for an int.
IDEAL = [
    Point(500.0, 33.0, 26.0),
    Point(900.0, 0.0, 12.0),
    Point(1200.0, 40.0, 26.0),
    Point(1500.0, 52.5, 26.0),
    Point(2500.0, 80.0, 20.0),
]
BANDED = [
    Point(1400.0, 20.0, 6.0),
    Point(1500.0, 58.0, 18.0),
    Point(1500.0, 52.0, 26.0),
    Point(2000.0, 85.0, 26.0),
    Point(2500.0, 45.0, 4.0),
]
CERTIFIED = [(0.0, point) for point in IDEAL] + [(0.25, point) for point in BANDED]


def _periodic(drive: Drive, point: Point) -> tuple[Phases, float]:
    """Return the phases in their certified periodic state and the angle at which they are in it."""
    phases = make_phases(drive)
    certified = periodic_start(
        drive, phases, make_phases(drive), point.speed, SUPPLY, point.reference, point.advance
    )
    assert certified == PERIODIC, f"{point} has no periodic state to test"
    return phases, 0.5 * (math.pi - drive.window) - point.advance


def _advanced(drive: Drive, phases: Phases, point: Point, angle: float, turn: float) -> np.ndarray:
    """Advance by an angle and return the totals."""
    totals = np.zeros(ledger.ENTRIES)
    status = advance_phases(
        drive,
        phases,
        angle,
        point.speed,
        SUPPLY,
        SUPPLY,
        point.reference,
        point.advance,
        turn / (drive.pole_pairs * point.speed),
        totals,
    )
    assert status == COMPLETED
    return totals


@pytest.mark.kernel
@pytest.mark.parametrize(("band", "point"), CERTIFIED)
def test_half_wave_symmetry(motor: Motor, band: float, point: Point) -> None:
    drive = motor(hysteresis_band=band)
    phases, angle = _periodic(drive, point)
    # Off the window's edge, where rounding decides which side of it a phase is on.
    _advanced(drive, phases, point, angle, 0.1)
    before = phases.currents.copy()
    first = _advanced(drive, phases, point, angle + 0.1, math.pi)
    np.testing.assert_allclose(phases.currents, -before, rtol=0.0, atol=1e-8)
    second = _advanced(drive, phases, point, angle + 0.1 + math.pi, math.pi)
    sums = [ledger.MAGNITUDE, ledger.SQUARE, ledger.IMPULSE, ledger.EXCHANGED, ledger.RETURNED]
    np.testing.assert_allclose(second[sums], first[sums], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(second[ledger.UPPER], first[ledger.LOWER], rtol=1e-9, atol=1e-12)


@pytest.mark.kernel
@pytest.mark.parametrize(("band", "point"), CERTIFIED)
def test_phases_are_equal_up_to_their_shift(motor: Motor, band: float, point: Point) -> None:
    drive = motor(hysteresis_band=band)
    phases, angle = _periodic(drive, point)
    shift = math.pi / drive.phases
    _advanced(drive, phases, point, angle, 0.1)
    before = phases.currents.copy()
    _advanced(drive, phases, point, angle + 0.1, shift)
    after = phases.currents
    np.testing.assert_allclose(after[1:], before[:-1], rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(after[0], -before[-1], rtol=0.0, atol=1e-8)


@pytest.mark.kernel
@pytest.mark.parametrize(("band", "point"), CERTIFIED)
def test_steady_state_and_transient_agree(motor: Motor, band: float, point: Point) -> None:
    drive = motor(hysteresis_band=band, core_loss_conductance=3e-3)
    state = steady_state(drive, point.speed, point.reference, point.advance)
    assert state.certified == PERIODIC
    phases = make_phases(drive, KEPT_TIME)
    cycle = 2.0 * math.pi / (drive.pole_pairs * point.speed)
    # A current that never rests forgets its start only within the winding's time constants.
    settling = 30.0 * drive.inductance / drive.resistance
    _advanced(drive, phases, point, 0.0, 2.0 * math.pi * max(40, math.ceil(settling / cycle)))
    totals = np.zeros(ledger.ENTRIES)
    status, lowest, highest = advance_with_extremes(
        drive, phases, 0.0, point.speed, SUPPLY, point.reference, point.advance, cycle, totals
    )
    assert status == COMPLETED
    means = totals / cycle
    current = max(state.current_sum, state.current_peak)
    drag = means[ledger.CORE_DRAG_IMPULSE]
    for name, value, scale in [
        ("torque", means[ledger.IMPULSE], drive.emf_constant * current),
        ("torque_lowest", lowest, drive.emf_constant * current),
        ("torque_highest", highest, drive.emf_constant * current),
        ("current_sum", means[ledger.MAGNITUDE], current),
        ("exchanged_power", means[ledger.EXCHANGED], SUPPLY * current),
        ("returned_power", means[ledger.RETURNED], SUPPLY * current),
        ("source_power", means[ledger.UPPER] + means[ledger.LOWER], SUPPLY * current),
        ("copper_loss", drive.resistance * means[ledger.SQUARE], state.copper_loss),
        ("core_loss", means[ledger.CORE_SOURCE] + drag * point.speed, state.core_loss),
        ("current_peak", totals[ledger.PEAK], current),
    ]:
        difference = abs(getattr(state, name) - value) / scale
        assert difference <= 1e-9, (
            f"{name}: {getattr(state, name)!r} by shooting, {value!r} in the transient, apart by {difference:.1e}"
        )


@pytest.mark.kernel
@pytest.mark.parametrize(("band", "point"), CERTIFIED)
def test_steady_power_balances(motor: Motor, band: float, point: Point) -> None:
    """Over a period nothing is stored: the supply feeds copper, devices and shaft alone."""
    drive = motor(hysteresis_band=band, switch_drop=0.9, diode_drop=0.7)
    state = steady_state(drive, point.speed, point.reference, point.advance)
    assert state.certified == PERIODIC
    arriving = state.copper_loss + state.torque * point.speed + state.device_loss
    assert abs(state.source_power - arriving) <= 1e-9 * state.exchanged_power
    assert abs(state.source_power - state.exchanged_power + 2.0 * state.returned_power) <= (
        1e-12 * state.exchanged_power
    )


class Scaling(NamedTuple):
    """Powers of a common factor by which constants and results change."""

    constants: dict[str, float]
    speed: float
    voltage: float
    reference: float
    results: dict[str, float]


TIME = Scaling(
    {"inductance": 1, "emf_constant": 1},
    speed=-1,
    voltage=0,
    reference=0,
    results={"torque": 1, "current_sum": 0, "source_power": 0, "copper_loss": 0, "core_loss": 0},
)
LEVEL = Scaling(
    {"half_supply_voltage": 1, "emf_constant": 1, "hysteresis_band": 1},
    speed=0,
    voltage=1,
    reference=1,
    results={"torque": 2, "current_sum": 1, "source_power": 2, "copper_loss": 2, "core_loss": 2},
)
IMPEDANCE = Scaling(
    {"resistance": -1, "inductance": -1, "hysteresis_band": 1, "core_loss_conductance": 1},
    speed=0,
    voltage=0,
    reference=1,
    results={"torque": 1, "current_sum": 1, "source_power": 1, "copper_loss": 1, "core_loss": 1},
)
WINDING = Scaling(
    # The same copper wound with another number of turns.
    {
        "resistance": 2,
        "inductance": 2,
        "emf_constant": 1,
        "half_supply_voltage": 1,
        "hysteresis_band": -1,
        "core_loss_conductance": -2,
    },
    speed=0,
    voltage=1,
    reference=-1,
    results={"torque": 0, "current_sum": -1, "source_power": 0, "copper_loss": 0, "core_loss": 0},
)


@pytest.mark.kernel
@pytest.mark.parametrize(
    "scaling", [TIME, LEVEL, IMPEDANCE, WINDING], ids=["time", "level", "impedance", "winding"]
)
@pytest.mark.parametrize(("band", "point"), CERTIFIED)
def test_scaling_laws(motor: Motor, scaling: Scaling, band: float, point: Point) -> None:
    factor = 1.7
    drive = motor(hysteresis_band=band, core_loss_conductance=3e-3)
    changed = drive._replace(
        **{name: getattr(drive, name) * factor**power for name, power in scaling.constants.items()}
    )
    base: SteadyState = cycles_from_rest(
        drive, make_phases(drive, KEPT_TIME), point.speed, SUPPLY, point.reference, point.advance, 3
    )
    scaled: SteadyState = cycles_from_rest(
        changed,
        make_phases(changed, 2.0 * KEPT_TIME),
        point.speed * factor**scaling.speed,
        SUPPLY * factor**scaling.voltage,
        point.reference * factor**scaling.reference,
        point.advance,
        3,
    )
    powers = scaling.results | {
        "torque_lowest": scaling.results["torque"],
        "torque_highest": scaling.results["torque"],
        "exchanged_power": scaling.results["source_power"],
        "returned_power": scaling.results["source_power"],
        "current_peak": scaling.results["current_sum"],
    }
    for name, power in powers.items():
        expected = getattr(base, name) * factor**power
        assert getattr(scaled, name) == pytest.approx(expected, rel=1e-9, abs=1e-9), f"{name} does not scale"


@st.composite
def commands(draw: st.DrawFn) -> tuple[float, Point, list[float]]:
    """Draw a band, an operating point and the shares into which an advance is cut."""
    band = draw(st.sampled_from([0.0, 0.25, 1.5]))
    point = Point(draw(st.floats(100.0, 2500.0)), draw(st.floats(0.0, 90.0)), draw(st.floats(0.0, 26.0)))
    return band, point, draw(st.lists(st.floats(0.01, 1.0), min_size=2, max_size=6))


@pytest.mark.kernel
@drawn
@given(commands(), st.floats(0.0, 6.3))
def test_cutting_an_advance_changes_nothing(
    motor: Motor, command: tuple[float, Point, list[float]], angle: float
) -> None:
    band, point, shares = command
    drive = motor(hysteresis_band=band, core_loss_conductance=3e-3)
    whole, cut = make_phases(drive), make_phases(drive)
    # Some way from rest, so that currents flow; then one advance, whole and in pieces.
    for phases in (whole, cut):
        _advanced(drive, phases, point, angle - 2.0, 2.0)
    turn = 0.6
    total = _advanced(drive, whole, point, angle, turn)
    pieces = np.zeros(ledger.ENTRIES)
    reached = angle
    for share in shares:
        piece = turn * share / sum(shares)
        part = _advanced(drive, cut, point, reached, piece)
        peak = max(pieces[ledger.PEAK], part[ledger.PEAK])
        pieces += part
        pieces[ledger.PEAK] = peak
        reached += piece
    np.testing.assert_allclose(cut.currents, whole.currents, rtol=0.0, atol=1e-10 * (1.0 + point.reference))
    pieces[ledger.EVENTS] = total[ledger.EVENTS]
    np.testing.assert_allclose(pieces, total, rtol=1e-10, atol=1e-10 * max(total[ledger.EXCHANGED], 1e-3))


def _torque_at(drive: Drive, phases: Phases, time: float) -> float:
    """Return the torque at a time of the last advance, from the exponential of each phase's segment."""
    total = 0.0
    rate = drive.resistance / drive.inductance
    for phase in range(drive.phases):
        rows = phases.rows[phase, : phases.row_counts[phase]]
        row = rows[max(int(np.searchsorted(rows[:, segments.START], time, side="right")) - 1, 0)]
        offset = time - row[segments.START]
        shape = row[segments.SHAPE] + row[segments.SHAPE_RATE] * offset
        current = row[segments.CURRENT]
        if row[segments.RATE] > 0.0:
            faded = -math.expm1(-rate * offset) / rate
            final = row[segments.CURVATURE] / rate
            current += (row[segments.SLOPE] + final) * faded - final * offset
        total += shape * current
    return drive.emf_constant * total


@pytest.mark.nightly
@pytest.mark.kernel
@drawn
@given(
    st.sampled_from([0.0, 0.25, 3.0]),
    st.builds(Point, st.floats(100.0, 2500.0), st.floats(0.0, 90.0), st.floats(0.0, 26.0)),
    st.floats(0.0, 6.3),
    st.sampled_from([0.08, 0.8, 5.0]),
)
def test_torque_extremes_are_exact(
    motor: Motor, band: float, point: Point, angle: float, resistance: float
) -> None:
    drive = motor(phases=3, hysteresis_band=band, resistance=resistance)
    phases = make_phases(drive, KEPT_TIME)
    _advanced(drive, phases, point, angle - 2.0, 2.0)
    duration = 0.5 * KEPT_TIME
    _advanced(drive, phases, point, angle, drive.pole_pairs * point.speed * duration)
    lowest, highest = torque_extremes(
        phases.rows,
        phases.row_counts,
        np.zeros(len(phases.row_counts), np.int64),
        drive.emf_constant,
        drive.resistance / drive.inductance,
        duration,
        math.inf,
        -math.inf,
    )
    events = {
        float(start) for k in range(3) for start in phases.rows[k, : phases.row_counts[k], segments.START]
    }
    times = np.array(sorted(events | set(np.linspace(0.0, duration, 60))))
    samples = np.array([_torque_at(drive, phases, time) for time in times])
    scale = 1.0 + np.abs(samples).max()
    assert samples.max() <= highest + 1e-12 * scale, (
        f"a sample of {samples.max()!r} N m exceeds {highest!r} N m"
    )
    assert samples.min() >= lowest - 1e-12 * scale, (
        f"a sample of {samples.min()!r} N m is below {lowest!r} N m"
    )
    for sign, bound in ((-1.0, highest), (1.0, lowest)):
        refined = math.inf
        for best in np.argsort(sign * samples)[:3]:
            found = minimize_scalar(
                lambda time, sign=sign: sign * _torque_at(drive, phases, time),
                bounds=(times[max(best - 1, 0)], times[min(best + 1, times.size - 1)]),
                method="bounded",
                options={"xatol": 1e-12},
            )
            refined = min(refined, found.fun, sign * samples[best])
        assert abs(sign * refined - bound) <= 1e-9 * scale, (
            f"refined samples reach {sign * refined!r} N m, the extreme is said to be {bound!r} N m"
        )


@pytest.mark.kernel
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("rate", [0.5, 50.0])
def test_two_stationary_points_within_one_interval(sign: float, rate: float) -> None:
    """A torque whose slope dips below zero and comes back looks monotone from both ends of its interval."""
    length = 0.5 / rate
    # Slope u**3/3 - u + 1/2 in u = 3 t/length - 3/2: above zero and rising at the start and at the end.
    times = np.linspace(0.0, length, 2001)
    u = 3.0 * times / length - 1.5
    target = sign * (u**4 / 12.0 - u**2 / 2.0 + 0.5 * u)
    faded = -np.expm1(-rate * times) / rate
    bent = (times - faded) / rate
    # Two phases, one at the peak of the shape and one at its zero, make every form that a torque can take.
    forms = np.column_stack([np.ones_like(times), times, faded, times * faded, -bent, -times * bent])
    scaling = np.abs(forms).max(axis=0)
    coefficients = np.linalg.lstsq(forms / scaling, target, rcond=None)[0] / scaling
    torque = forms @ coefficients
    peak = int(np.argmax(sign * torque))
    assert 0 < peak < times.size - 1, "the premise: the extreme lies within the interval"

    rows = np.zeros((2, 1, segments.FIELDS))
    rows[:, 0, segments.LENGTH] = length
    rows[:, 0, segments.RATE] = rate
    rows[0, 0, segments.SHAPE] = 1.0
    rows[1, 0, segments.SHAPE_RATE] = 1.0
    columns = (segments.CURRENT, segments.SLOPE, segments.CURVATURE)
    for column, values in zip(columns, coefficients.reshape(3, 2), strict=True):
        rows[:, 0, column] = values
    lowest, highest = torque_extremes(
        rows, np.ones(2, np.int64), np.zeros(2, np.int64), 1.0, rate, length, math.inf, -math.inf
    )
    assert highest == pytest.approx(torque.max(), abs=1e-6), "the highest torque is missed"
    assert lowest == pytest.approx(torque.min(), abs=1e-6), "the lowest torque is missed"
