"""The comparison of drives: the same candidates on each, in tables of absolute and per-unit figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final

from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.comparison import DrivePoint, Row, mean_of
from drivegate.drives.abilities import ability_of
from drivegate.drives.constant_power import ConstantPower
from drivegate.scenarios.drive_scale import scale_of
from drivegate.studies.compare.compared_drive import ComparedDrive
from drivegate.studies.compare.document import sealed
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

BASES_IN_WORDS: Final = (
    "Per unit (pu): speed over base speed, torque over that of rated power at base speed, Σ|i| over phases times "
    "the current limit, powers and losses over rated power."
)
"""The bases in words."""
_SHOWN_OF_HASH: Final = 8
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


@dataclass(frozen=True)
class Bases:
    """What one per unit is on a drive."""

    speed_rpm: float
    """Base speed (rpm)."""
    torque_nm: float
    """Torque of rated power at base speed (N·m)."""
    current_sum_a: float
    """Current limit of all phases (A)."""
    power_w: float
    """Rated power (W)."""

    def document(self) -> dict[str, float]:
        """Return the bases as plain data."""
        return asdict(self)


def bases_of(drive: DriveDocument) -> Bases:
    """Return the per-unit bases of a drive."""
    rating = drive.rating
    return Bases(
        speed_rpm=rating.base_speed_rpm,
        torque_nm=scale_of(drive).rated_torque_nm,
        current_sum_a=drive.machine.phases * rating.current_limit_a,
        power_w=rating.rated_power_w,
    )


def drive_labels(drives: Sequence[DriveDocument]) -> tuple[str, ...]:
    """Label every drive by its name, and by its hash where another has the same name."""
    names = [drive.name for drive in drives]
    for place, drive in enumerate(drives):
        same = next((other for other in drives[:place] if other.values_hash == drive.values_hash), None)
        if same is not None:
            raise InputError(
                f"the drives '{same.name}' and '{drive.name}' have the same values, so there is nothing to compare "
                "between them; name each drive once"
            )
    return tuple(
        drive.name if names.count(drive.name) == 1 else f"{drive.name} ({drive.values_hash[:_SHOWN_OF_HASH]})"
        for drive in drives
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


def operating_rows(labels: Sequence[str], made: Sequence[ComparedDrive]) -> list[Row]:
    """List the points of each candidate on each drive, at the same shares of range and rating."""
    rows: list[Row] = []
    for label, one in zip(labels, made, strict=True):
        bases = bases_of(one.request.drive)
        points_of = contract_of(one.request.drive).comparison().drive_points
        for compared in one.all_compared:
            for point in points_of(one.request, one.plan, compared.figures):
                where = {"candidate": compared.label, "drive": label, "speed_share": point.speed_share}
                rows.append(where | _operating_row(point, bases))
    return rows


def _operating_row(point: DrivePoint, bases: Bases) -> Row:
    row: Row = {
        "load_percent": point.load_percent,
        "speed_rpm": point.speed_rpm,
        "speed_pu": point.speed_rpm / bases.speed_rpm,
        "torque_nm": point.torque_nm,
        "torque_pu": point.torque_nm / bases.torque_nm,
        "held": point.held,
        "ripple_percent": point.ripple_percent,
        "current_sum_a": point.current_sum_a,
        "current_sum_pu": point.current_sum_a / bases.current_sum_a,
        "input_power_w": point.input_power_w,
        "input_power_pu": point.input_power_w / bases.power_w,
    }
    return row | _losses(point, bases)


def _losses(point: DrivePoint, bases: Bases) -> Row:
    """Split the losses of a steady run; a speed that is not held takes or gives kinetic energy besides."""
    watts: Row = dict.fromkeys(("shaft_power", "losses", "electrical_losses", "mechanical_losses"))
    efficiency = None
    if point.held:
        speed, power = point.speed_mean_rpm * RADIANS_PER_RPM, point.input_power_w
        shaft, at_gap = point.torque_nm * speed, point.torque_mean_nm * speed
        watts = {
            "shaft_power": shaft,
            "losses": power - shaft,
            "electrical_losses": power - at_gap,
            "mechanical_losses": at_gap - shaft,
        }
        efficiency = 100.0 * shaft / power if power > 0.0 else None
    return {
        "efficiency_percent": efficiency,
        **{f"{key}_w": value for key, value in watts.items()},
        **{f"{key}_pu": None if value is None else value / bases.power_w for key, value in watts.items()},
    }


def summary_rows(labels: Sequence[str], made: Sequence[ComparedDrive], points: Sequence[Row]) -> list[Row]:
    """Put the drives side by side for each candidate, over the points that it holds on all of them."""
    rows: list[Row] = []
    for place, compared in enumerate(made[0].all_compared):
        own = [row for row in points if row["candidate"] == compared.label]
        shared = _held_on_all(own, labels)
        for label, one in zip(labels, made, strict=True):
            here = [row for row in own if row["drive"] == label]
            rows.append(_summary_row(label, one, place, here, shared))
    return rows


_Place = tuple[float, float]


def _place(row: Row) -> _Place:
    return row["speed_share"], row["load_percent"]


def _held_on_all(rows: Sequence[Row], labels: Sequence[str]) -> set[_Place]:
    held = [{_place(row) for row in rows if row["drive"] == label and row["held"]} for label in labels]
    return set.intersection(*held)


def _summary_row(
    label: str, made: ComparedDrive, place: int, points: Sequence[Row], shared: set[_Place]
) -> Row:
    compared = made.all_compared[place]
    over = [row for row in points if _place(row) in shared]
    # That of most torque a controller of duty ratios is given is a little less than rated power takes.
    heaviest = max((row["load_percent"] for row in points), default=None)
    full = [row for row in points if row["load_percent"] == heaviest]
    shaft, power = (mean_of(row[key] for row in over) for key in ("shaft_power_w", "input_power_w"))
    failed = compared.failed_checks
    return {
        "candidate": compared.label,
        "drive": label,
        "status": compared.status,
        "required_failed": None if failed is None else len(failed),
        "points_held": sum(row["held"] for row in points),
        "points": len(points),
        "points_shared": len(over),
        **{key: mean_of(row[key] for row in over) for key in _MEANS},
        "efficiency_percent": 100.0 * shaft / power if shaft is not None and power else None,
        "ripple_full_load_percent": max(
            (row["ripple_percent"] for row in over if row["load_percent"] == heaviest), default=None
        ),
        **_held_up_to(full),
    }


def _held_up_to(full: Sequence[Row]) -> Row:
    """Return up to which of the run speeds rated power was held without a gap."""
    reached: Row = {"rated_power_held_up_to_rpm": None, "rated_power_held_up_to_pu": None}
    for row in sorted(full, key=lambda row: float(row["speed_rpm"])):
        if not row["held"]:
            break
        reached = {
            "rated_power_held_up_to_rpm": row["speed_rpm"],
            "rated_power_held_up_to_pu": row["speed_pu"],
        }
    return reached


def drive_comparison_document(
    labels: Sequence[str], made: Sequence[ComparedDrive], *, timing: Mapping[str, Any]
) -> dict[str, Any]:
    """Return a comparison of drives as plain data: bases, candidates, tables, and the comparison on each drive.

    Each drive has a different label; `timing` is left out of the content hash.
    """
    points = operating_rows(labels, made)
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
                "per_unit": bases_of(drive).document(),
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
            "operating_points": points,
            "greatest_power": power_rows(labels, drives, ranges),
        },
        "parts": parts,
    }
    return sealed(content, _hashed, timing)


def _hashed(content: dict[str, Any]) -> dict[str, Any]:
    """Represent each part by its own hash, which leaves out what differs from run to run."""
    return {**content, "parts": [part["provenance"]["content_hash"] for part in content["parts"]]}
