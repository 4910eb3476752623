"""What the paper publishes beside what the models give, computed when the report is made."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final, Literal, TypeAlias, get_args

import numpy as np

from drivegate.builtin_loading import BuiltinController
from drivegate.scenario_run import run_scenario
from drivegate_cases.document import parse_document
from drivegate_cases.facts import Fact, Quantity, facts
from drivegate_cases.operating_point import load_operating_point
from drivegate_cases.scenario import Scenario
from drivegate_models import observation
from drivegate_models.builtin_controllers import SEARCHES
from drivegate_models.oracle import feasible_edge, point_at_torque
from drivegate_models.steady_state import steady_state
from drivegate_reports.figures.input_current import input_current_sweep
from drivegate_reports.figures.instantaneous_torque import ADVANCE_DEG, torque_cycle
from drivegate_reports.figures.phase_currents import POINTS, phase_currents
from drivegate_reports.figures.search_trajectory import search_trajectory
from drivegate_reports.reference_drive import RADIANS_PER_RPM, ideal_drive, power_torque, reference_motor
from drivegate_reports.style import signed

Verdict: TypeAlias = Literal["reproduced", "not reproduced", "open in the paper", "taken as given"]

FASTEST_PROBED_RPM: Final = 4000.0
"""Speed up to which constant power is looked for."""
HIGHEST_PUBLISHED_RPM: Final = 1500.0
"""Greatest speed of the published results, three times base speed."""


@dataclass(frozen=True)
class Comparison:
    """A published statement beside ours.

    Attributes
    ----------
    fact : str
        Number of the fact, such as ``P8``.
    quantity : str
        What is compared.
    published, ours : str
        Both with their units.
    residual, tolerance : str
        Ours minus the published value, and what is allowed; empty where they have no number.
    verdict : str
        ``reproduced``, ``not reproduced``, ``open in the paper``, or ``taken as given`` for a value that the
        model has as an input, so that agreement proves nothing.
    note : str
        How ours was had.
    """

    fact: str
    quantity: str
    published: str
    ours: str
    residual: str
    tolerance: str
    verdict: Verdict
    note: str


@dataclass(frozen=True)
class Ours:
    """A value of ours for a published quantity.

    Attributes
    ----------
    value : float
        In the quantity's unit.
    note : str
        How it was had.
    given : bool
        Whether it is an input of the model.
    is_open : bool
        Whether the paper leaves open what exactly is meant.
    """

    value: float
    note: str = ""
    given: bool = False
    is_open: bool = False


def _given(value: float) -> Ours:
    return Ours(value, "input of the model", given=True)


def _rated_power() -> Ours:
    motor = reference_motor()
    speed = motor.base_speed_rpm * RADIANS_PER_RPM
    angles = np.radians(np.arange(0.0, 90.0, 0.25))
    torques = [steady_state(ideal_drive(), speed, motor.current_limit_a, angle).torque for angle in angles]
    best = int(np.argmax(torques))
    at = math.degrees(angles[best])
    return Ours(
        torques[best] * speed, f"greatest power at {motor.base_speed_rpm:g} rpm and 26 A, at {at:.2f}°"
    )


def _angle_below_base() -> Ours:
    """Run the published controller through base speed on a dynamometer, and look at what it commands below."""
    base = reference_motor().base_speed_rpm
    ramp = {
        "schema": 1,
        "name": "through base speed",
        "motor": reference_motor().to_mapping(),
        "duration_s": 1.0,
        "speed_rpm": [[0.0, base - 100.0], [1.0, base + 100.0]],
        "load": {"kind": "locked"},
    }
    scenario = parse_document(ramp, Scenario, "the ramp through base speed")
    run = run_scenario(scenario, BuiltinController(SEARCHES["published"]))
    angle = math.degrees(float(run.run[observation.RUN_ANGLE_BELOW_BASE]))
    return Ours(angle, "greatest angle that `published` commands below base speed, on a ramp through it")


def _necessary_angle(point_name: str) -> Ours:
    point = load_operating_point(point_name)
    edge = feasible_edge(ideal_drive(), point.speed_rpm * RADIANS_PER_RPM, point.torque_nm)
    return Ours(math.degrees(edge), f"smallest angle that gives {point.torque_nm:g} N·m at the current limit")


def _fig10_angle() -> Ours:
    point = load_operating_point("fig10-currents-1500")
    speed = point.speed_rpm * RADIANS_PER_RPM
    found = point_at_torque(ideal_drive(), speed, math.radians(point.advance_deg), point.torque_nm)
    edge = _necessary_angle("fig10-currents-1500").value
    return Ours(
        point.advance_deg,
        f"{'feasible' if found.robust else 'not feasible'}, with Σ|i| {found.current_sum:.1f} A; the smallest "
        f"feasible angle is {edge:.1f}°. The paper does not say whether 58° is an initial or an optimal angle",
        is_open=True,
    )


def _ripple() -> Ours:
    point = load_operating_point("fig6-torque-1500")
    found = torque_cycle(point.advance_deg)
    beside = torque_cycle(ADVANCE_DEG)
    return Ours(
        found.ripple_percent,
        f"peak to peak over mean at {point.advance_deg:g}° and {point.torque_nm:g} N·m; "
        f"{beside.ripple_percent:.1f} % at {ADVANCE_DEG:g}°",
    )


def _speed_ratio() -> Ours:
    motor = reference_motor()
    speeds = np.arange(HIGHEST_PUBLISHED_RPM, FASTEST_PROBED_RPM + 1.0, 100.0)
    edges = [
        feasible_edge(ideal_drive(), speed * RADIANS_PER_RPM, power_torque(speed, motor.rated_power_w))
        for speed in speeds
    ]
    reached = [(speed, edge) for speed, edge in zip(speeds, edges, strict=True) if math.isfinite(edge)]
    speed, edge = reached[-1]
    return Ours(
        speed / motor.base_speed_rpm,
        f"1.5 kW is within reach at {speed:.0f} rpm from {math.degrees(edge):.1f}° on; looked no further",
    )


def _angle_of_greatest_speed() -> Ours:
    return Ours(
        90.0,
        "no greatest speed is stated; ours still gives 1.5 kW at the fastest speed looked at, far below 90°",
        is_open=True,
    )


_NOT_SIMULATED = "a drive of another work, not described in the paper and not simulated here"

_OURS: Final[Mapping[tuple[str, str], Callable[[], Ours]]] = {
    ("P1", "phases"): lambda: _given(reference_motor().phases),
    ("P1", "poles"): lambda: _given(2 * reference_motor().pole_pairs),
    ("P1", "shift between neighbouring phases"): lambda: _given(180.0 / reference_motor().phases),
    ("P1", "conduction in each half cycle"): lambda: _given(reference_motor().window_deg),
    ("P2", "voltage of one half of the supply"): lambda: _given(reference_motor().supply_voltage_v),
    ("P2", "switches"): lambda: _given(2 * reference_motor().phases),
    ("P3", "rated power"): _rated_power,
    ("P3", "base speed"): lambda: _given(reference_motor().base_speed_rpm),
    ("P3", "rated phase current"): lambda: _given(reference_motor().current_limit_a),
    ("P5", "speed below which the angle is zero"): lambda: _given(reference_motor().base_speed_rpm),
    ("P5", "angle below that speed"): _angle_below_base,
    ("P7", "speed of Fig. 9"): lambda: _given(load_operating_point(POINTS[0]).speed_rpm),
    ("P7", "torque of Fig. 9"): lambda: _given(load_operating_point(POINTS[0]).torque_nm),
    ("P7", "angle of Fig. 9"): lambda: _necessary_angle("fig9-currents-1200"),
    ("P7", "speed of Fig. 10"): lambda: _given(load_operating_point(POINTS[1]).speed_rpm),
    ("P7", "torque of Fig. 10"): lambda: _given(load_operating_point(POINTS[1]).torque_nm),
    ("P7", "angle of Fig. 10"): _fig10_angle,
    ("P8", "necessary angle at 1500 rpm"): lambda: _necessary_angle("fig6-torque-1500"),
    ("P8", "torque ripple at 1500 rpm"): _ripple,
    ("P9", "ripple of a surface-magnet drive"): lambda: Ours(math.nan, _NOT_SIMULATED, is_open=True),
    ("P9", "ripple of an inset-magnet drive"): lambda: Ours(math.nan, _NOT_SIMULATED, is_open=True),
    ("P10", "angle of the greatest speed"): _angle_of_greatest_speed,
    ("P10", "greatest speed over base speed"): _speed_ratio,
}


def quantity_keys() -> frozenset[tuple[str, str]]:
    """List the published quantities that have a value of ours.

    Returns
    -------
    frozenset of tuple of str
        Fact and name of the quantity.
    """
    return frozenset(_OURS)


@cache
def comparisons() -> tuple[Comparison, ...]:
    """Compare every published quantity and statement with what the models give.

    Returns
    -------
    tuple of Comparison
        In the order of the facts.
    """
    rows: list[Comparison] = []
    for fact in facts():
        rows += [_compared(fact, quantity) for quantity in fact.quantities]
        rows += [compare() for compare in _STATEMENTS.get(fact.id, ())]
    return tuple(rows)


def verdict_counts(rows: Sequence[Comparison]) -> tuple[tuple[Verdict, int], ...]:
    """Count the verdicts.

    Parameters
    ----------
    rows : sequence of Comparison
        The comparisons.

    Returns
    -------
    tuple of tuple
        Each verdict with its number of comparisons.
    """
    verdicts = [row.verdict for row in rows]
    return tuple((verdict, verdicts.count(verdict)) for verdict in get_args(Verdict))


def _compared(fact: Fact, quantity: Quantity) -> Comparison:
    ours = _OURS[fact.id, quantity.name]()
    relation = {"equal": "", "at_most": "at most ", "at_least": "at least "}[quantity.bound]
    bounded = quantity.bound != "equal"
    known = math.isfinite(ours.value) and not ours.is_open
    if ours.is_open:
        verdict: Verdict = "open in the paper"
    elif ours.given:
        verdict = "taken as given"
    else:
        verdict = "reproduced" if quantity.agrees(ours.value) else "not reproduced"
    at_least = "at least " if quantity.bound == "at_least" else ""
    return Comparison(
        fact=fact.id,
        quantity=quantity.name,
        published=relation + _with_unit(quantity.value, quantity.unit),
        ours=at_least + _with_unit(ours.value, quantity.unit) if known else "–",
        residual=_difference(ours.value - quantity.value, quantity.unit) if known else "",
        tolerance="a limit" if bounded else _tolerance(quantity),
        verdict=verdict,
        note=ours.note,
    )


def _tolerance(quantity: Quantity) -> str:
    if quantity.tolerance is None:
        return ""
    return "exact" if quantity.tolerance == 0.0 else f"± {_with_unit(quantity.tolerance, quantity.unit)}"


def _with_unit(value: float, unit: str) -> str:
    gap = "" if unit in ("", "deg") else " "
    return f"{value:.4g}{gap}{'°' if unit == 'deg' else unit}"


def _difference(value: float, unit: str) -> str:
    text = _with_unit(float(f"{value:.2g}"), unit)
    return f"+{text}" if value > 0.0 else text.replace("-", "−")


def _power_sum() -> Comparison:
    data = torque_cycle()
    speed = data.speed_rpm * RADIANS_PER_RPM
    point = point_at_torque(ideal_drive(), speed, math.radians(data.advance_deg), data.mean_nm)
    product = ideal_drive().half_supply_voltage * point.current_sum
    return Comparison(
        fact="P4",
        quantity=f"net input power at 1500 rpm, 9.8 N·m, {data.advance_deg:g}°",
        published=f"V·Σ|i| = {product:.0f} W",
        ours=f"{point.input_power:.0f} W",
        residual=f"{signed(point.input_power - product, 0)} W",
        tolerance="equal",
        verdict="not reproduced",
        note=f"V·Σ|i| is the power exchanged with the half-sources, {point.exchanged_power:.0f} W; "
        f"{point.returned_power:.0f} W of it flow back through the diodes (finding F3)",
    )


def out_of_reach_rpm() -> tuple[float, float]:
    """Find where the published line of the initial angle does not give rated power.

    Returns
    -------
    tuple of float
        Base speed, and the speed from which on the line lies above the feasible edge up to 1500 rpm (rpm),
        interpolated between the sweep's speeds.
    """
    data = input_current_sweep()
    below = np.flatnonzero((data.published_deg < data.edge_deg) & (data.speed_rpm <= HIGHEST_PUBLISHED_RPM))
    base = reference_motor().base_speed_rpm
    if below.size == 0:
        return base, base
    last = int(below[-1])
    gap = data.published_deg[last : last + 2] - data.edge_deg[last : last + 2]
    return base, float(np.interp(0.0, gap, data.speed_rpm[last : last + 2]))


def _published_line() -> Comparison:
    start, end = out_of_reach_rpm()
    return Comparison(
        fact="P5",
        quantity="1.5 kW along a line from 0° at base speed to 58° at 1500 rpm",
        published="at every high speed",
        ours=f"out of reach from {start:.0f} to {end:.0f} rpm" if end > start else "at every speed",
        residual="",
        tolerance="",
        verdict="not reproduced" if end > start else "reproduced",
        note="at the current limit; the slope itself is not published (finding F2)",
    )


def _literal_search() -> Comparison:
    data = search_trajectory()
    error = float(data.published.speed_error_rpm[-1])
    holds = abs(error) <= 5.0
    return Comparison(
        fact="P6",
        quantity="Fig. 4 taken literally, at 1500 rpm and 9.8 N·m",
        published="ends at the least Σ|i|",
        ours="holds the speed" if holds else f"{signed(error, 0)} rpm, saturated, frozen",
        residual="",
        tolerance="k1 = 5 rpm",
        verdict="reproduced" if holds else "not reproduced",
        note=f"`reference` stops at Σ|i| {data.reference.current_sum_a[-1]:.2f} A, the least is "
        f"{data.optimum_current_sum_a:.2f} A (finding F4)",
    )


def _current_slopes() -> Comparison:
    slow, fast = (phase_currents(name) for name in POINTS)
    falls = slow.slope_a_per_ms < 0.0 and fast.slope_a_per_ms < slow.slope_a_per_ms
    return Comparison(
        fact="P7",
        quantity="slope of the current before its window closes, 1200 and 1500 rpm",
        published="falls at both, faster at 1500 rpm",
        ours=f"{signed(slow.slope_a_per_ms, 1)} and {signed(fast.slope_a_per_ms, 1)} A/ms",
        residual="",
        tolerance="",
        verdict="reproduced" if falls else "not reproduced",
        note=f"the peak EMF is {slow.peak_emf_v:.1f} V at 1200 rpm, below the half-supply's 48 V, and "
        f"{fast.peak_emf_v:.1f} V at 1500 rpm: with this calibration only the faster current falls; the order of the "
        "slopes is as published",
    )


def _worst_ripple() -> Comparison:
    data = input_current_sweep()
    within = data.speed_rpm <= HIGHEST_PUBLISHED_RPM
    speeds, ripple = data.speed_rpm[within], data.optimal_ripple_percent[within]
    worst = int(np.argmax(ripple))
    return Comparison(
        fact="P8",
        quantity="ripple of 1.5 kW at the optimal angle, 550 to 1500 rpm",
        published="below 13 %, worst at 1500 rpm",
        ours=f"{ripple.min():.1f} to {ripple[worst]:.1f} %, worst at {speeds[worst]:.0f} rpm",
        residual=f"{signed(ripple[worst] - 13.0, 1)} %",
        tolerance="a limit",
        verdict="reproduced" if ripple[worst] < 13.0 else "not reproduced",
        note="9.55 N·m exactly on the feasible edge, less torque at a smaller angle than Fig. 6; at the initial angle "
        f"at most {data.initial_ripple_percent[within].max():.1f} %",
    )


def _current_saving() -> Comparison:
    saving = input_current_sweep().current_saving_percent
    return Comparison(
        fact="P12",
        quantity="Σ|i| saved by the optimal angle, 550 to 2000 rpm",
        published="marked, at every speed",
        ours=f"{saving.min():.1f} to {saving.max():.1f} %",
        residual="",
        tolerance="",
        verdict="reproduced" if saving.min() > 0.0 else "not reproduced",
        note="against the initial angle of 33° + 0.025°/rpm above base speed; the paper's own line is not published",
    )


def _power_saving() -> Comparison:
    saving = input_current_sweep().power_saving_percent
    return Comparison(
        fact="P12",
        quantity="net input power saved by it",
        published="in proportion to Σ|i|",
        ours=f"{saving.min():.2f} to {saving.max():.2f} %",
        residual="",
        tolerance="",
        verdict="not reproduced",
        note="most of the current that is saved only circulates between the half-sources (finding F3)",
    )


_STATEMENTS: Final[Mapping[str, tuple[Callable[[], Comparison], ...]]] = {
    "P4": (_power_sum,),
    "P5": (_published_line,),
    "P6": (_literal_search,),
    "P7": (_current_slopes,),
    "P8": (_worst_ripple,),
    "P12": (_current_saving, _power_saving),
}
