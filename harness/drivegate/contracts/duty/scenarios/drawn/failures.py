"""Drawn failures of sensors and of the drive."""

from __future__ import annotations

from collections.abc import Collection
from typing import Final

from hypothesis import strategies as st

from drivegate.contracts.duty.scenarios.building import (
    edge_positions,
    failing,
    share_scenario,
    speed_scenario,
    torque_of,
    with_edges,
)
from drivegate.contracts.duty.scenarios.drawn.steps import Drawn, shares_between, speeds_between
from drivegate.contracts.duty.scenarios.drawn_range import FAILURE_TORQUE_SHARE, HEAVIEST_FAILURE_SHARE
from drivegate.scenarios.changes import with_real_sensors
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.limits import FAILURE_SPEED_SHARE
from drivegate_cases.scenario.failure import PHASED
from drivegate_cases.scenario.failure_kind import FAILURE_KINDS, FailureKind
from drivegate_cases.scenario.reference import FollowedReference, Reference
from drivegate_cases.scenario.scenario import Scenario

_PART: Final = 0.005
SLIPS_DEG: Final = (-120.0, -60.0, 45.0, 90.0, 180.0)
"""Angles that a magnet slips by (electrical degrees): less than 45 costs little torque, and may go unnoticed."""
_UNSEEN: Final = frozenset({("locked-rotor", "torque"), ("lost-edge", "speed")})


def failure_scenarios(
    drive: PmAcDocument,
    detected: Collection[FailureKind] = FAILURE_KINDS,
    references: Collection[FollowedReference] = ("speed", "torque"),
) -> Drawn:
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
        held = share_scenario(drive, speed, share)
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
        st.sampled_from(that_can_fail(drive, detected, references)),
        shares_between(FAILURE_TORQUE_SHARE, HEAVIEST_FAILURE_SHARE),
        speeds_between(drive, FAILURE_SPEED_SHARE * base, base),
        st.integers(0, 20),
        st.integers(1, 3),
        st.sampled_from((0, 1, 2)),
        st.sampled_from(SLIPS_DEG),
    )


def that_can_fail(
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
        and (kind not in ("lost-position", "lost-edge") or drive.has_sensor)
        and kind in detected
        and reference in references
        and (kind, reference) not in _UNSEEN
    ]
