"""The comparison of drives: the same candidates on each, in tables of absolute and per-unit figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

import pandas as pd

from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.comparison import DRIVE_POINT, Row, mean_of
from drivegate.drives.abilities import ability_of
from drivegate.drives.constant_power import ConstantPower
from drivegate.scenarios.drive_scale import scale_of
from drivegate.studies.compare.compared_drive import ComparedDrive
from drivegate.studies.compare.document import sealed
from drivegate.studies.compare.ranking import frame_of, held_by_all, rows_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.units import RADIANS_PER_RPM

BASES_IN_WORDS: Final = (
    "Per unit (pu): speed over base speed, torque over that of rated power at base speed, Σ|i| over phases times "
    "the current limit, powers and losses over rated power."
)
"""The bases in words."""
LOSSES_IN_WORDS: Final = (
    "Losses are input power less the load's. Electrical ones lie between the supply and the torque: windings, bridge, "
    "and the core of connected phases; mechanical ones between the torque and the load: friction, the core of phases "
    "that float, and what a speed that still moves stores."
)
"""How losses are split."""
_MEANS: Final = (
    "current_sum_pu",
    "current_sum_a",
    "input_power_pu",
    "input_power_w",
    "losses_pu",
    "losses_w",
)
SCHEMA: Final = 1
"""Version of the document."""
KIND: Final = "drive-comparison"
"""Kind of the document."""


class Bases(NamedTuple):
    """What one per unit is on a drive."""

    speed_rpm: float
    """Base speed (rpm)."""
    torque_nm: float
    """Torque of rated power at base speed (N·m)."""
    current_sum_a: float
    """Current limit of all phases (A)."""
    power_w: float
    """Rated power (W)."""


def bases_of(drive: DriveDocument) -> Bases:
    """Return the per-unit bases of a drive."""
    rating = drive.rating
    return Bases(
        speed_rpm=rating.base_speed_rpm,
        torque_nm=scale_of(drive).rated_torque_nm,
        current_sum_a=drive.machine.phases * rating.current_limit_a,
        power_w=rating.rated_power_w,
    )


def drive_rows(
    labels: Sequence[str], drives: Sequence[DriveDocument], ranges: Sequence[ConstantPower]
) -> list[Row]:
    """List the drives with their bases, and how far they keep rated power."""
    return [_drive_row(*row) for row in zip(labels, drives, ranges, strict=True)]


def _drive_row(label: str, drive: DriveDocument, power: ConstantPower) -> Row:
    rating, bases = drive.rating, bases_of(drive)
    reached_rpm = None if power.reached is None else round(power.reached / RADIANS_PER_RPM, 6)
    return {
        "drive": label,
        "hash": drive.values_hash,
        "phases": drive.machine.phases,
        "supply_voltage_v": contract_of(drive).comparison().supply_voltage_v(drive),
        "rated_power_w": rating.rated_power_w,
        "current_limit_a": rating.current_limit_a,
        "base_speed_rpm": rating.base_speed_rpm,
        "highest_speed_rpm": rating.highest_speed_rpm,
        "overspeed_rpm": rating.overspeed_rpm,
        "base_torque_nm": bases.torque_nm,
        "base_current_sum_a": bases.current_sum_a,
        "constant_power_up_to_rpm": reached_rpm,
        "constant_power_up_to_pu": None if reached_rpm is None else round(reached_rpm / bases.speed_rpm, 6),
    }


def power_rows(
    labels: Sequence[str], drives: Sequence[DriveDocument], ranges: Sequence[ConstantPower]
) -> list[Row]:
    """List the greatest power of each drive at the shaft over speed, whatever the controller."""
    rows: list[Row] = []
    for label, drive, found in zip(labels, drives, ranges, strict=True):
        bases = bases_of(drive)
        for speed, power in zip(found.speeds, found.powers, strict=True):
            rpm = round(speed / RADIANS_PER_RPM, 6)
            rows.append(
                {
                    "drive": label,
                    "speed_rpm": rpm,
                    "speed_pu": rpm / bases.speed_rpm,
                    "greatest_power_w": power,
                    "greatest_power_pu": power / bases.power_w,
                }
            )
    return rows


def operating_points(labels: Sequence[str], made: Sequence[ComparedDrive]) -> pd.DataFrame:
    """Return the points of each candidate on each drive, at the same shares of range and rating.

    Losses are those of a speed that is held; any other takes or gives kinetic energy besides.
    """
    rows = [
        {"candidate": compared.label, "drive": label, **point}
        for label, one in zip(labels, made, strict=True)
        for compared in one.all_compared
        for point in contract_of(one.request.drive)
        .comparison()
        .drive_points(one.request, one.plan, compared.figures)
    ]
    points = frame_of(rows, "candidate", "drive", *DRIVE_POINT)
    points["held"] = points["held"].astype(bool)
    bases = pd.DataFrame([bases_of(one.request.drive)._asdict() for one in made], list(labels))
    bases = bases.loc[points["drive"]]
    bases.index = points.index
    speed, power = points["speed_mean_rpm"] * RADIANS_PER_RPM, points["input_power_w"]
    shaft, at_gap = points["torque_nm"] * speed, points["torque_mean_nm"] * speed
    watts = pd.DataFrame(
        {
            "shaft_power_w": shaft,
            "losses_w": power - shaft,
            "electrical_losses_w": power - at_gap,
            "mechanical_losses_w": at_gap - shaft,
        }
    ).where(points["held"])
    points["speed_pu"] = points["speed_rpm"] / bases["speed_rpm"]
    points["torque_pu"] = points["torque_nm"] / bases["torque_nm"]
    points["current_sum_pu"] = points["current_sum_a"] / bases["current_sum_a"]
    points["input_power_pu"] = power / bases["power_w"]
    points["efficiency_percent"] = (100.0 * shaft / power).where(points["held"] & (power > 0.0))
    per_unit = watts.div(bases["power_w"], axis=0).rename(columns=lambda key: f"{key.removesuffix('_w')}_pu")
    return pd.concat((points, watts, per_unit), axis=1)[[*_OPERATING_POINT, *watts, *per_unit]]


_OPERATING_POINT: Final = (
    *("candidate", "drive", "speed_share", "load_percent", "speed_rpm", "speed_pu", "torque_nm", "torque_pu"),
    *("held", "ripple_percent", "current_sum_a", "current_sum_pu", "input_power_w", "input_power_pu"),
    "efficiency_percent",
)
"""Columns of the operating points, before their losses."""


def summary_rows(labels: Sequence[str], made: Sequence[ComparedDrive], points: pd.DataFrame) -> list[Row]:
    """Put the drives side by side for each candidate, over the points that it holds on all of them."""
    rows: list[Row] = []
    for place, compared in enumerate(made[0].all_compared):
        own = points[points["candidate"] == compared.label]
        shared = held_by_all(own, "drive", labels, ("speed_share", "load_percent"))
        for label, one in zip(labels, made, strict=True):
            here, over = (frame[frame["drive"] == label] for frame in (own, shared))
            status = one.all_compared[place]
            failed = status.failed_checks
            rows.append(
                {
                    "candidate": compared.label,
                    "drive": label,
                    "status": status.status,
                    "required_failed": None if failed is None else len(failed),
                    "points_held": int(here["held"].sum()),
                    "points": len(here),
                    "points_shared": len(over),
                    **_means(here, over),
                }
            )
    return rows_of(pd.DataFrame(rows, dtype=object))


def _means(here: pd.DataFrame, over: pd.DataFrame) -> Row:
    """Summarize the points of a candidate on a drive: those that it holds on all drives, and all at full load."""
    # That of most torque a controller of duty ratios is given is a little less than rated power takes.
    heaviest = here["load_percent"].max()
    full = here[here["load_percent"] == heaviest].sort_values("speed_rpm", kind="stable")
    without_gap = full[full["held"].cummin().astype(bool)]
    reached = without_gap[["speed_rpm", "speed_pu"]].iloc[-1].tolist() if len(without_gap) else (None, None)
    shaft, power = mean_of(over["shaft_power_w"]), mean_of(over["input_power_w"])
    return {
        **{key: mean_of(over[key]) for key in _MEANS},
        "efficiency_percent": 100.0 * shaft / power if power else None,
        "ripple_full_load_percent": over.loc[over["load_percent"] == heaviest, "ripple_percent"].max(),
        **dict(zip(("rated_power_held_up_to_rpm", "rated_power_held_up_to_pu"), reached, strict=True)),
    }


def drive_comparison_document(
    labels: Sequence[str], made: Sequence[ComparedDrive], *, timing: Mapping[str, Any]
) -> dict[str, Any]:
    """Return a comparison of drives as plain data: bases, candidates, tables, and the comparison on each drive.

    Each drive has a different label; `timing` is left out of the content hash.
    """
    points = operating_points(labels, made)
    drives = [one.request.drive for one in made]
    ranges = [ability_of(drive).constant_power(drive) for drive in drives]
    parts = [one.document for one in made if one.document is not None]
    content: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": KIND,
        "effort": made[0].request.effort,
        "seed": made[0].request.seed,
        "bases": BASES_IN_WORDS,
        "losses": LOSSES_IN_WORDS,
        "drives": [
            {
                "label": label,
                **drive.identity(),
                "per_unit": bases_of(drive)._asdict(),
                # A name is anybody's text.
                "folder": f"drive-{number}",
            }
            for number, (label, drive) in enumerate(zip(labels, drives, strict=True), 1)
        ],
        "candidates": [
            {key: entry[key] for key in ("label", "specification", "kind", "hash")}
            for entry in parts[0]["candidates"]
        ],
        "tables": {
            "summary": summary_rows(labels, made, points),
            "drives": drive_rows(labels, drives, ranges),
            "operating_points": rows_of(points),
            "greatest_power": power_rows(labels, drives, ranges),
        },
        "parts": parts,
    }
    return sealed(content, _hashed, timing)


def _hashed(content: dict[str, Any]) -> dict[str, Any]:
    """Represent each part by its own hash, which leaves out what differs from run to run."""
    return {**content, "parts": [part["provenance"]["content_hash"] for part in content["parts"]]}
