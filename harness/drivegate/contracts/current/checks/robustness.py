"""Checks that the search converges too where plant and sensors are not what they should be."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from drivegate.checks.check import Check, Evaluate
from drivegate.checks.margin import Margin, Moment, worst_required
from drivegate.contracts.current.checks.convergence import ABOVE_BASE_SPEED, moment_of, worst_convergence
from drivegate.contracts.current.record import CurrentRecord, SteadyWindow
from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.plant import Scales
from drivegate_cases.scenario.circumstance import Circumstance

_ROUNDING = 1e-9


def claimed(drive: DriveDocument) -> dict[str, tuple[float, float]]:
    """Return the ranges of the plant's parameters in which convergence is required, by key of `Scales`."""
    return {
        "resistance": (0.5, 2.0),
        "inductance": (0.8, 1.2),
        "emf_constant": (0.95, 1.05),
        "friction_added_n_m": (0.0, scale_of(drive).friction_claimed_nm),
    }


def is_claimed(scales: Scales, drive: DriveDocument) -> bool:
    """Return True if convergence is required of a plant with such parameters."""
    ranges = claimed(drive)
    values = scales.model_dump(include=set(ranges))
    return all(
        lowest - _ROUNDING <= values[key] <= highest + _ROUNDING for key, (lowest, highest) in ranges.items()
    )


def robust_convergence(check: str, judged: Circumstance) -> Evaluate:
    """Make the function that judges convergence in runs of one circumstance."""

    def evaluate(record: CurrentRecord) -> Margin | None:
        if record.circumstance is not judged:
            return None
        margins = [
            replace(margin, measured=f"{'CNV-3' if window.is_after_change else 'CNV-1'}: {margin.measured}")
            for window in _claimed_windows(record)
            if (margin := worst_convergence(check, [window])) is not None
        ]
        return worst_required(margins)

    return evaluate


def robust_moment(record: CurrentRecord) -> Moment | None:
    """Show the window that has converged least."""
    return moment_of(record, _claimed_windows(record))


def _claimed_windows(record: CurrentRecord) -> Iterator[SteadyWindow]:
    return (window for window in record.windows() if is_claimed(window.scales, record.scenario.drive))


ROB_1 = Check(
    id="ROB-1",
    families=("parameter",),
    requirement=(
        "CNV-1 and CNV-3 hold with half to twice the resistance, 20 % more or less inductance, 5 % more or less EMF, "
        "and up to {friction} of friction added."
    ),
    source="P11",
    limit="k1 = {k1}, k2 = {k2} of Σ|i|, {angle}",
    scenarios=(
        "every loaded steady stretch of {stretch} or more above base speed, on a plant that differs from its nameplate"
    ),
    formula="as CNV-1",
    why="The search is to need no model of the losses and to be insensitive to the motor's parameters.",
    evaluate=robust_convergence("ROB-1", Circumstance.PARAMETERS),
    moment=robust_moment,
    reason_not_applicable=ABOVE_BASE_SPEED,
)
ROB_2 = Check(
    id="ROB-2",
    families=("sensor", "phase"),
    requirement="CNV-1 and CNV-3 hold through {sensors}.",
    source="P6, P11",
    limit="k1 = {k1}, k2 = {k2} of Σ|i| and what two steps of the speed measurement are worth, {angle}",
    scenarios="every loaded steady stretch of {stretch} or more above base speed, through sensors that are not ideal",
    formula="as CNV-1, on the true speed and the true currents",
    why="A search compares small differences of Σ|i|, which offsets, noise and a converter's steps blur.",
    evaluate=robust_convergence("ROB-2", Circumstance.SENSORS),
    moment=robust_moment,
    reason_not_applicable=ABOVE_BASE_SPEED,
)
ROB_3 = Check(
    id="ROB-3",
    families=("phase", "fault"),
    requirement="CNV-1 and CNV-3 hold after {disturbed_sensors}, and with {disturbed_plant}.",
    source="P6, P11",
    limit="k1 = {k1}, k2 = {k2} of Σ|i| (through {speed_sensor} as ROB-2), {angle}",
    scenarios="every loaded steady stretch of {stretch} or more above base speed, in runs with such a disturbance",
    formula="as CNV-1",
    why="What one bad measurement leaves in a controller's memory must not stay there for good.",
    evaluate=robust_convergence("ROB-3", Circumstance.FAULTS),
    moment=robust_moment,
    reason_not_applicable=ABOVE_BASE_SPEED,
)
