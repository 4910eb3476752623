"""Drawn plants, sensors and disturbances that a controller has to do with."""

from __future__ import annotations

import math
from typing import Any, Final

from hypothesis import strategies as st

from drivegate.contracts.duty.scenarios.building import (
    lifted_scenario,
    load_step_scenario,
    most_false_edges,
    restarted,
    share_scenario,
    speed_and_load_step_scenario,
    supply_step_scenario,
    torque_of,
    with_false_edges,
    with_lost_samples,
    with_position_errors,
)
from drivegate.contracts.duty.scenarios.drawn.steps import (
    GREATEST_SEED,
    Drawn,
    held_or_loaded_runs,
    runs_from_below,
    shares_between,
    speeds_up_to_base,
    turning_speeds,
)
from drivegate.contracts.duty.scenarios.drawn_range import HEAVIEST_SHARE, SHARE_STEP
from drivegate.scenarios.changes import CLOCKS_S, with_scales
from drivegate.scenarios.drive_scale import tidy
from drivegate.scenarios.title import titled
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import SHUNTS, position_of
from drivegate_models.units import RADIANS_PER_RPM

MOST_PARTS: Final = 9
"""Most electrical degrees that the errors of a position sensor add up to."""
LATEST_S: Final = 1e-3
"""Greatest latency of a position sensor (s)."""


def parameter_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw plants that differ from the nameplate, in steps of the speed or of the load.

    R × 0.5 to 2, L × 0.7 to 1.3, ψ × 0.8 to 1.05 and J × 0.3 to 2, also while a wheel is lifted and set down.
    """
    base = drive.rating.base_speed_rpm
    lifted = st.builds(
        lambda share, begin, speed, inertias: lifted_scenario(
            drive,
            speed,
            torque_of(drive, speed, share),
            inertias,
            initial_speed_rpm=tidy(begin * min(speed, base)),
        ),
        shares_between(0.1, 0.7),
        st.sampled_from((0.4, 0.6, 0.8)),
        turning_speeds(drive),
        st.sampled_from(((2.0, 0.3), (2.0, 0.5), (1.5, 0.5), (1.0, 0.3), (2.0, 1.0))),
    )
    others = st.builds(
        lambda run, inertia, resistance, inductance, flux: with_scales(
            run(inertia_factor=inertia),
            inertia=inertia,
            resistance=round(1.0 + 0.1 * resistance, 2),
            inductance=round(1.0 + 0.05 * inductance, 2),
            emf_constant=round(1.0 + 0.05 * flux, 2),
        ),
        runs_from_below(drive),
        st.sampled_from((1.0, 0.3, 0.5, 1.5, 2.0)),
        st.integers(-5, 10).filter(bool),
        st.integers(-6, 6),
        st.integers(-4, 1),
    )
    return st.one_of(others, others, lifted)


def sensor_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw sensors, with steps of the speed or of the load from 10 % of base speed on.

    Shunts are in line, or below the lower switches up to base speed. The shaft has an encoder of 256 to 4096 lines, or
    what the drive states.
    """

    def seen(run: Scenario, shunts: str, lines: int, seed: int) -> Scenario:
        # Below the lower switches no shunts see two phases at full voltage.
        fast = max(abs(speed) for _, speed in run.speed_rpm) > drive.rating.base_speed_rpm
        given: dict[str, Any] = {"shunts": "in-line" if fast else shunts}
        if position_of(SHUNTS, drive) == "encoder":
            given["encoder_lines"] = lines
        return titled(run.replaced(sensors=SHUNTS.model_copy(update=given), seed=seed))

    return st.builds(
        seen,
        runs_from_below(drive).map(lambda run: run()),
        st.sampled_from(("in-line", "low-side")),
        st.sampled_from((256, 512, 1024, 4096)),
        st.integers(1, GREATEST_SEED),
    )


def restart_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw resets of the controller while the drive runs, one or five, and clocks that do not begin at 0."""
    resets = st.sampled_from(((0.5,), (0.3, 0.35, 0.4, 0.45, 0.5)))
    beginnings = st.one_of(
        st.tuples(resets, st.sampled_from(CLOCKS_S)),
        st.tuples(st.just(()), st.sampled_from(CLOCKS_S[1:])),
    )
    return st.builds(
        lambda run, beginning: restarted(run, *beginning), held_or_loaded_runs(drive), beginnings
    )


def position_error_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw a position sensor without edges: eccentric, with unequal tracks, and late, of up to 9 electrical degrees."""
    if drive.position != "exact":
        return st.nothing()
    pairs = drive.machine.pole_pairs
    base = drive.rating.base_speed_rpm * RADIANS_PER_RPM
    degrees = st.integers(-3, 3)

    def made(run: Scenario, parts: tuple[int, ...], turn: float, seed: int) -> Scenario:
        eccentric, sine, cosine, gain, phase, late = parts
        return with_position_errors(
            run,
            seed,
            eccentricity_deg=tidy(abs(eccentric) / pairs),
            eccentric_from_deg=turn if eccentric else 0.0,
            sine_offset=round(0.5 * math.radians(sine) / pairs, 5),
            cosine_offset=round(0.5 * math.radians(cosine) / pairs, 5),
            track_gain=round(math.radians(gain) / pairs, 5),
            track_phase_deg=tidy(phase / pairs),
            latency_s=min(round(math.radians(abs(late)) / (pairs * base), 7), LATEST_S),
        )

    parts = st.tuples(*[degrees] * 6).filter(lambda each: 0 < sum(map(abs, each)) <= MOST_PARTS)
    return st.builds(
        made,
        held_or_loaded_runs(drive),
        parts,
        st.integers(0, 7).map(lambda eighth: 45.0 * eighth),
        st.integers(1, GREATEST_SEED),
    )


def lost_sample_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw single samples of currents, speed or link voltage that read 0, one or five of them."""
    signals = (
        ("currents", None),
        ("currents", 1),
        ("currents", 2),
        ("currents", 3),
        *((("speed", None),) if drive.has_sensor else ()),
        ("supply", None),
    )
    return st.builds(
        lambda run, signal, shares: with_lost_samples(run, signal[:1], shares, signal[1]),
        held_or_loaded_runs(drive),
        st.sampled_from(signals),
        st.sampled_from(((0.2,), (0.1, 0.12, 0.14, 0.16, 0.18))),
    )


def false_edge_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw false edges of an encoder that turn the rotor's frame by up to 3 electrical degrees."""
    most = most_false_edges(drive)
    if most == 0 or drive.position in ("hall", "none"):
        return st.nothing()
    return st.builds(
        with_false_edges,
        held_or_loaded_runs(drive),
        st.integers(-most, most).filter(bool),
        st.just(0.1),
        st.integers(1, GREATEST_SEED),
    )


def joint_change_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw steps of a torque, of a load, or of speed and load, with a link step, a lost sample or a restart at once.

    Torques are up to 85 % of the rated one either way, and loads 30 to 70 %: with less, a search for the least loss has
    little to go by.
    """

    def load_step(loads: tuple[float, float], speed: float) -> Scenario:
        return load_step_scenario(drive, speed, torque_of(drive, speed, 1.0), loads)

    def stepped(
        is_torque: bool, torques: tuple[float, float], loads: tuple[float, float], speed: float
    ) -> Scenario:
        if is_torque:
            return share_scenario(drive, speed, *torques)
        return load_step(loads, speed)

    torques = st.tuples(*[shares_between(-HEAVIEST_SHARE, HEAVIEST_SHARE)] * 2)
    loads = st.tuples(*[shares_between(0.3, 0.7)] * 2)
    steps = st.builds(stepped, st.booleans(), torques, loads, turning_speeds(drive))
    slow = speeds_up_to_base(drive)
    slow_steps = st.builds(stepped, st.booleans(), torques, loads, slow)
    linked = st.builds(
        lambda run, level: supply_step_scenario(run, drive, (1.0, round(1.0 + SHARE_STEP * level, 2))),
        steps,
        st.integers(-3, 3).filter(bool),
    )
    lost = st.builds(
        lambda run, signal, share: with_lost_samples(run, (signal,), (share,)),
        slow_steps,
        st.sampled_from(("currents", "speed", "supply")),
        st.sampled_from((0.5, 0.501)),
    )
    # Not at a step of the torque: STP-1 judges the response of a controller that has settled.
    restarts = st.builds(lambda shares, speed: restarted(load_step(shares, speed), (0.5,)), loads, slow)
    both = st.builds(
        lambda shares, first, second: speed_and_load_step_scenario(
            drive, (first, second), torque_of(drive, max(first, second), 1.0), shares
        ),
        loads,
        turning_speeds(drive),
        turning_speeds(drive),
    )
    return st.one_of(linked, lost, restarts, both)
