"""Scenarios of a PM AC drive drawn by Hypothesis, as whole steps from plain ones."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from functools import partial
from typing import Final, TypeAlias

from hypothesis import strategies as st

from drivegate.contracts.duty.scenarios.building import (
    edge_positions,
    failing,
    hoist_scenario,
    lifted_scenario,
    load_step_scenario,
    most_false_edges,
    restarted,
    slow_torque,
    speed_and_load_step_scenario,
    speed_scenario,
    stop_scenario,
    supply_step_scenario,
    torque_of,
    torque_scenario,
    vanishing_load_scenario,
    with_edges,
    with_false_edges,
    with_fan,
    with_lost_samples,
    with_position_errors,
)
from drivegate.contracts.duty.scenarios.drawn_range import (
    BEYOND_SHARE,
    BRAKING_SHARE,
    FAILURE_TORQUE_SHARE,
    HEAVIEST_FAILURE_SHARE,
    HEAVIEST_SHARE,
    SHARE_STEP,
    SLOW_SHARE,
    TURNING_SHARE,
)
from drivegate.scenarios.changes import CLOCKS_S, with_real_sensors, with_scales
from drivegate.scenarios.drive_scale import tidy
from drivegate.scenarios.rotation import goes_backward, is_mirrored, mirrored
from drivegate.scenarios.title import titled
from drivegate_cases.drive.limits import nearest_step
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.limits import FAILURE_SPEED_SHARE
from drivegate_cases.scenario.failure import PHASED
from drivegate_cases.scenario.failure_kind import FAILURE_KINDS, FailureKind
from drivegate_cases.scenario.reference import FollowedReference, Reference, reference_of
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import SHUNTS, position_of
from drivegate_models.units import RADIANS_PER_RPM

Family: TypeAlias = Callable[[PmAcDocument], st.SearchStrategy[Scenario]]
"""From a drive to scenarios of one kind."""

_SEEDS: Final = 10_000
_PART: Final = 0.005
MOST_PARTS: Final = 9
"""Most electrical degrees that the errors of a position sensor add up to."""
LATEST_S: Final = 1e-3
"""Greatest latency of a position sensor (s)."""
SLIPS_DEG: Final = (-120.0, -60.0, 45.0, 90.0, 180.0)
"""Angles that a magnet slips by (electrical degrees): less than 45 costs little torque, and may go unnoticed."""


def _speeds(drive: PmAcDocument, lowest: float, highest: float) -> st.SearchStrategy[float]:
    """Draw a speed in steps of about 2 % of base speed (rpm)."""
    step = nearest_step(0.02 * drive.rating.base_speed_rpm)
    return st.integers(int(-(-lowest // step)), int(highest // step)).map(lambda count: tidy(count * step))


def _any_speed(drive: PmAcDocument) -> st.SearchStrategy[float]:
    return _speeds(drive, 0.0, drive.rating.highest_speed_rpm)


def _turning(drive: PmAcDocument) -> st.SearchStrategy[float]:
    return _speeds(drive, TURNING_SHARE * drive.rating.base_speed_rpm, drive.rating.highest_speed_rpm)


def _shares(lowest: float, highest: float) -> st.SearchStrategy[float]:
    steps = st.integers(round(lowest / SHARE_STEP), round(highest / SHARE_STEP))
    return steps.map(lambda count: round(SHARE_STEP * count, 2))


def torque_step_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw steps of the torque reference up to the rated one either way, from standstill to the highest speed."""
    return st.builds(
        lambda shares, speed: torque_scenario(
            drive, speed, [torque_of(drive, speed, share) for share in shares]
        ),
        st.tuples(_shares(0.0, 1.0), _shares(-BRAKING_SHARE, 1.0), _shares(-BRAKING_SHARE, 1.0)),
        _any_speed(drive),
    )


def weakening_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw torque references above base speed that ask for more than rated power, and then for nothing."""
    rating = drive.rating
    return st.builds(
        lambda share, speed: torque_scenario(drive, speed, (0.0, torque_of(drive, speed, share), 0.0)),
        _shares(1.5, BEYOND_SHARE),
        _speeds(drive, 1.02 * rating.base_speed_rpm, rating.highest_speed_rpm),
    )


def _from_below(drive: PmAcDocument) -> st.SearchStrategy[Callable[[float], Scenario]]:
    """Draw runs that begin below base speed, where no controller must know the plant to hold the current.

    Each is long enough for the factor on the inertia that it is called with.
    """
    base = drive.rating.base_speed_rpm
    speeds = st.builds(
        lambda share, first, second: (
            lambda inertia: speed_scenario(
                drive,
                (first, second),
                torque_nm=torque_of(drive, max(first, second), share),
                initial_speed_rpm=min(first, base),
                inertia_factor=inertia,
            )
        ),
        _shares(0.0, 0.7),
        _turning(drive),
        _turning(drive),
    )
    loads = st.builds(
        lambda shares, speed: (
            lambda inertia: load_step_scenario(
                drive,
                speed,
                torque_of(drive, speed, 1.0),
                shares,
                initial_speed_rpm=min(speed, base),
                inertia_factor=inertia,
            )
        ),
        st.tuples(_shares(0.0, HEAVIEST_SHARE), _shares(0.0, HEAVIEST_SHARE)),
        _turning(drive),
    )
    return st.one_of(speeds, loads)


def speed_step_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw steps between any two speeds under a constant torque of up to 70 % of the rated one."""
    return st.builds(
        lambda share, first, second: speed_scenario(
            drive, (first, second), torque_nm=torque_of(drive, max(first, second), share)
        ),
        _shares(0.0, 0.7),
        _turning(drive),
        _turning(drive),
    )


def reversal_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw steps from a speed forward to one backward, under a torque or a fan of up to 70 % of rated torque."""

    def made(share: float, first: float, second: float, is_fan: bool) -> Scenario:
        torque = torque_of(drive, max(first, second), share)
        run = speed_scenario(drive, (first, -second), torque_nm=torque)
        return with_fan(run) if is_fan else run

    return st.builds(made, _shares(0.0, 0.7), _turning(drive), _turning(drive), st.booleans())


def hoist_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw a weight of up to 60 % of rated torque, lifted or lowered, that comes on, or reverses between both."""
    heaviest = _shares(0.1, HEAVIEST_FAILURE_SHARE)
    base = drive.rating.base_speed_rpm

    def made(share: float, first: float, second: float, how: str) -> Scenario:
        torque = torque_of(drive, base, share)
        if how == "reversal":
            return hoist_scenario(drive, (first, -second), torque)
        return hoist_scenario(drive, (first if how == "lift" else -first,), torque, (0.0, 1.0))

    speeds = _speeds(drive, TURNING_SHARE * base, base)
    return st.builds(made, heaviest, speeds, speeds, st.sampled_from(("lift", "lower", "reversal")))


def load_step_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw steps of the load between shares of up to 85 % of rated torque, or a load that vanishes for a moment."""
    steps = st.builds(
        lambda shares, speed: load_step_scenario(drive, speed, torque_of(drive, speed, 1.0), shares),
        st.tuples(_shares(0.0, HEAVIEST_SHARE), _shares(0.0, HEAVIEST_SHARE)),
        _turning(drive),
    )
    moments = st.builds(
        lambda share, speed, gone: vanishing_load_scenario(
            drive, speed, torque_of(drive, speed, share), gone
        ),
        _shares(0.1, HEAVIEST_SHARE),
        _turning(drive),
        st.sampled_from((0.001, 0.01, 0.05, 0.2)),
    )
    return st.one_of(steps, steps, moments)


def start_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw starts from standstill at any angle of the rotor, up to base speed under up to 80 % of rated torque."""
    return st.builds(
        lambda angle, share, speed: speed_scenario(
            drive,
            (speed,),
            torque_nm=torque_of(drive, speed, share),
            initial_speed_rpm=0.0,
            initial_angle_deg=angle,
        ),
        st.integers(0, 359).map(float),
        _shares(0.0, 0.8),
        _speeds(drive, TURNING_SHARE * drive.rating.base_speed_rpm, drive.rating.base_speed_rpm),
    )


def parameter_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
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
        _shares(0.1, 0.7),
        st.sampled_from((0.4, 0.6, 0.8)),
        _turning(drive),
        st.sampled_from(((2.0, 0.3), (2.0, 0.5), (1.5, 0.5), (1.0, 0.3), (2.0, 1.0))),
    )
    others = st.builds(
        lambda run, inertia, resistance, inductance, flux: with_scales(
            run(inertia),
            inertia=inertia,
            resistance=round(1.0 + 0.1 * resistance, 2),
            inductance=round(1.0 + 0.05 * inductance, 2),
            emf_constant=round(1.0 + 0.05 * flux, 2),
        ),
        _from_below(drive),
        st.sampled_from((1.0, 0.3, 0.5, 1.5, 2.0)),
        st.integers(-5, 10).filter(bool),
        st.integers(-6, 6),
        st.integers(-4, 1),
    )
    return st.one_of(others, others, lifted)


def supply_step_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw steps of the link's voltage within 85 to 115 % of the nominal one, at one operating point."""
    return st.builds(
        lambda share, levels, speed: supply_step_scenario(
            load_step_scenario(drive, speed, torque_of(drive, speed, share), (1.0,)),
            drive,
            (1.0, *(round(1.0 + SHARE_STEP * level, 2) for level in levels)),
        ),
        _shares(0.0, 0.8),
        st.tuples(st.integers(-3, 3), st.integers(-3, 3)),
        _turning(drive),
    )


def torque_supply_step_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw the same steps under a torque reference of up to the rated torque either way."""
    return st.builds(
        lambda share, levels, speed: supply_step_scenario(
            torque_scenario(drive, speed, (torque_of(drive, speed, share),)),
            drive,
            (1.0, *(round(1.0 + SHARE_STEP * level, 2) for level in levels)),
        ),
        _shares(-BRAKING_SHARE, 1.0),
        st.tuples(st.integers(-3, 3), st.integers(-3, 3)),
        _any_speed(drive),
    )


def low_speed_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw runs that end at 1 to 10 % of base speed: from standstill, a higher speed, or a stop of 0.1 to 3 s.

    The load is up to 20 % of rated torque at the end of this range, and less in proportion to the speed below it.
    """
    base = drive.rating.base_speed_rpm

    def made(share: float, slow: float, fast: float, how: str, wait: float) -> Scenario:
        torque = slow_torque(drive, slow, share)
        if how == "load":
            return load_step_scenario(drive, slow, torque, (0.0, 1.0))
        if how == "start":
            return speed_scenario(drive, (slow,), torque_nm=torque, initial_speed_rpm=0.0)
        if how == "stop":
            return stop_scenario(drive, fast, wait, slow)
        return speed_scenario(drive, (fast, slow))

    return st.builds(
        made,
        st.sampled_from((0.25, 0.5, 0.75, 1.0)),
        st.integers(1, 9).map(lambda percent: tidy(percent * SLOW_SHARE * base)),
        _turning(drive),
        st.sampled_from(("load", "start", "fall", "stop")),
        st.sampled_from((0.1, 0.5, 1.0, 3.0)),
    )


def sensor_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw sensors, with steps of the speed or of the load from 10 % of base speed on.

    Shunts are in line, or below the lower switches up to base speed. The shaft has an encoder of 256 to 4096 lines, or
    what the drive states.
    """
    has_encoder = position_of(SHUNTS, drive) == "encoder"
    return st.builds(
        lambda run, shunts, lines, seed: titled(
            run.replaced(
                sensors=SHUNTS.model_copy(
                    update={"shunts": _possible(drive, run, shunts)}
                    | ({"encoder_lines": lines} if has_encoder else {})
                ),
                seed=seed,
            )
        ),
        _from_below(drive).map(lambda run: run(1.0)),
        st.sampled_from(("in-line", "low-side")),
        st.sampled_from((256, 512, 1024, 4096)),
        st.integers(1, _SEEDS),
    )


def _held_or_loaded(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw runs at one operating point up to base speed, of a torque or of a speed."""

    def made(share: float, speed: float, gives_torque: bool) -> Scenario:
        torque = torque_of(drive, speed, share)
        if gives_torque:
            return torque_scenario(drive, speed, (torque,))
        return speed_scenario(drive, (speed,), torque_nm=torque)

    base = drive.rating.base_speed_rpm
    return st.builds(made, _shares(0.1, 0.7), _speeds(drive, TURNING_SHARE * base, base), st.booleans())


def restart_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw resets of the controller while the drive runs, one or five, and clocks that do not begin at 0."""
    resets = st.sampled_from(((0.5,), (0.3, 0.35, 0.4, 0.45, 0.5)))
    beginnings = st.one_of(
        st.tuples(resets, st.sampled_from(CLOCKS_S)),
        st.tuples(st.just(()), st.sampled_from(CLOCKS_S[1:])),
    )
    return st.builds(lambda run, beginning: restarted(run, *beginning), _held_or_loaded(drive), beginnings)


def position_error_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
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
        _held_or_loaded(drive),
        parts,
        st.integers(0, 7).map(lambda eighth: 45.0 * eighth),
        st.integers(1, _SEEDS),
    )


def lost_sample_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw single samples of currents, speed or link voltage that read 0, one or five of them."""
    signals = (
        ("currents", None),
        ("currents", 1),
        ("currents", 2),
        ("currents", 3),
        ("speed", None),
        ("supply", None),
    )
    return st.builds(
        lambda run, signal, shares: with_lost_samples(run, signal[:1], shares, signal[1]),
        _held_or_loaded(drive),
        st.sampled_from(signals),
        st.sampled_from(((0.2,), (0.1, 0.12, 0.14, 0.16, 0.18))),
    )


def joint_change_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw steps of a torque, of a load, or of speed and load, with a link step, a lost sample or a restart at once.

    Torques are up to 85 % of the rated one either way, and loads 30 to 70 %: with less, a search for the least loss has
    little to go by.
    """
    base = drive.rating.base_speed_rpm

    def load_step(loads: tuple[float, float], speed: float) -> Scenario:
        return load_step_scenario(drive, speed, torque_of(drive, speed, 1.0), loads)

    def stepped(
        is_torque: bool, torques: tuple[float, float], loads: tuple[float, float], speed: float
    ) -> Scenario:
        if is_torque:
            return torque_scenario(drive, speed, [torque_of(drive, speed, share) for share in torques])
        return load_step(loads, speed)

    torques = st.tuples(*[_shares(-HEAVIEST_SHARE, HEAVIEST_SHARE)] * 2)
    loads = st.tuples(*[_shares(0.3, 0.7)] * 2)
    steps = st.builds(stepped, st.booleans(), torques, loads, _turning(drive))
    slow = _speeds(drive, TURNING_SHARE * base, base)
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
        _turning(drive),
        _turning(drive),
    )
    return st.one_of(linked, lost, restarts, both)


def false_edge_scenarios(drive: PmAcDocument) -> st.SearchStrategy[Scenario]:
    """Draw false edges of an encoder that turn the rotor's frame by up to 3 electrical degrees."""
    most = most_false_edges(drive)
    if most == 0 or drive.position == "hall":
        return st.nothing()
    return st.builds(
        with_false_edges,
        _held_or_loaded(drive),
        st.integers(-most, most).filter(bool),
        st.just(0.1),
        st.integers(1, _SEEDS),
    )


def failure_scenarios(
    drive: PmAcDocument,
    detected: Collection[FailureKind] = FAILURE_KINDS,
    references: Collection[FollowedReference] = ("speed", "torque"),
) -> st.SearchStrategy[Scenario]:
    """Draw failures in the second half of a run from 20 to 100 % of base speed under 30 to 60 % of rated torque.

    `detected` is what may fail. A rotor locks up under a speed reference, and an edge is lost under a torque.
    """
    base = drive.rating.base_speed_rpm

    def made(
        which: tuple[FailureKind, Reference],
        share: float,
        speed: float,
        part: int,
        phase: int,
        seed: int,
        slip_deg: float,
    ) -> Scenario:
        kind, reference = which
        torque = torque_of(drive, speed, share)
        held = torque_scenario(drive, speed, (torque,))
        run = held if reference == "torque" else speed_scenario(drive, (speed,), torque_nm=torque)
        if kind == "lost-edge":
            # The number of a phase, which an edge has none of, shows whose edge it is.
            seen = with_edges(run, edge_positions(drive)[0 if phase == 1 else -1], seed)
        elif kind == "slip":
            seen = run
        else:
            seen = with_real_sensors(run, seed) if seed else run
        time = (0.5 + _PART * part) * run.duration_s
        slipped = slip_deg if kind == "slip" else None
        return failing(seen, kind, time, phase if kind in PHASED else 1, slipped)

    return st.builds(
        made,
        st.sampled_from(_that_can_fail(drive, detected, references)),
        _shares(FAILURE_TORQUE_SHARE, HEAVIEST_FAILURE_SHARE),
        _speeds(drive, FAILURE_SPEED_SHARE * base, base),
        st.integers(0, 20),
        st.integers(1, 3),
        st.sampled_from((0, 1, 2)),
        st.sampled_from(SLIPS_DEG),
    )


_UNSEEN: Final = frozenset({("locked-rotor", "torque"), ("lost-edge", "speed")})


def _that_can_fail(
    drive: PmAcDocument, detected: Collection[FailureKind], references: Collection[FollowedReference]
) -> list[tuple[FailureKind, Reference]]:
    """List what may fail under which reference.

    A rotor that locks up is to follow a speed; what a lost edge does to the torque shows where one is asked for.
    """
    return [
        (kind, reference)
        for kind in FAILURE_KINDS
        for reference in ("speed", "torque")
        if (kind != "slip" or drive.position == "exact")
        and kind in detected
        and reference in references
        and (kind, reference) not in _UNSEEN
    ]


def _possible(drive: PmAcDocument, run: Scenario, shunts: str) -> str:
    """Choose shunts that see two phases at all times: below the lower switches none do at full voltage."""
    fast = max(abs(speed) for _, speed in run.speed_rpm) > drive.rating.base_speed_rpm
    return "in-line" if fast else shunts


FAMILY_GROUPS: Final[tuple[tuple[Family, ...], ...]] = (
    (torque_step_scenarios,),
    (weakening_scenarios,),
    (speed_step_scenarios, reversal_scenarios),
    (load_step_scenarios, low_speed_scenarios, hoist_scenarios),
    (start_scenarios, torque_step_scenarios, failure_scenarios, restart_scenarios),
    (parameter_scenarios,),
    (
        supply_step_scenarios,
        torque_supply_step_scenarios,
        sensor_scenarios,
        position_error_scenarios,
        lost_sample_scenarios,
        false_edge_scenarios,
    ),
    (weakening_scenarios, parameter_scenarios, joint_change_scenarios),
)
"""Families of scenarios that a shard of the search draws from; shards take turns at them."""


_OF_BOTH_SENSES: Final = frozenset({reversal_scenarios, hoist_scenarios})
_BACKWARD_SHARE: Final = 4
"""One run in so many is drawn backward."""
_OF_EITHER: Final = frozenset(
    {
        restart_scenarios,
        position_error_scenarios,
        lost_sample_scenarios,
        false_edge_scenarios,
        joint_change_scenarios,
    }
)
_OF_TORQUE: Final = frozenset({torque_step_scenarios, torque_supply_step_scenarios, weakening_scenarios})


def drawn_scenarios(
    drive: PmAcDocument,
    group: int | None = None,
    references: Collection[FollowedReference] = ("speed", "torque"),
    detected: Collection[FailureKind] = (),
    *,
    reverses: bool = True,
) -> st.SearchStrategy[Scenario]:
    """Draw a scenario of any family, or of one group of them, as far as a candidate follows or detects it.

    One in four turns backward where both candidate and drive reverse.
    """
    reverses = reverses and drive.one_way_because is None
    failures = partial(failure_scenarios, detected=detected, references=references)
    can_fail = bool(_that_can_fail(drive, detected, references))
    followed = [
        [
            failures if family is failure_scenarios else partial(_following, family, references)
            for family in families
            if (reverses or family not in _OF_BOTH_SENSES)
            and (drive.weakens or family is not weakening_scenarios)
            and (can_fail if family is failure_scenarios else _reference(family) in (*references, None))
        ]
        for families in FAMILY_GROUPS
    ]
    groups = [families for families in followed if families]
    chosen = groups if group is None else [groups[group % len(groups)]]
    drawn = st.one_of([family(drive) for families in chosen for family in families])
    if not reverses:
        return drawn
    turned = st.integers(0, _BACKWARD_SHARE - 1).map(lambda number: number == _BACKWARD_SHARE - 1)
    return st.builds(_turned, drawn, turned)


def _turned(run: Scenario, backward: bool) -> Scenario:
    """Mirror a run that is to go backward, and does not already."""
    return mirrored(run) if backward and is_mirrored(run) and not goes_backward(run) else run


def _reference(family: Family) -> Reference | None:
    """Return the reference of a family's runs; None where they have either."""
    if family in _OF_EITHER:
        return None
    return "torque" if family in _OF_TORQUE else "speed"


def _following(
    family: Family, references: Collection[FollowedReference], drive: PmAcDocument
) -> st.SearchStrategy[Scenario]:
    """Draw the runs of a family that have one of the references."""
    drawn = family(drive)
    return drawn.filter(lambda run: reference_of(run) in references) if family in _OF_EITHER else drawn
