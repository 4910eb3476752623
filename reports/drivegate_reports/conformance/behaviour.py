"""How a controller of duty ratios behaves, as the page shows it: figures, and losses in a table."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any, Final

from pydantic import ValidationError

from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.best_operation import trajectories
from drivegate.contracts.duty.document import duty_document
from drivegate.results.sections import BehaviourSection, EfficiencyPointSection
from drivegate_cases.documents.wording import figure
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_reports.conformance.figures import (
    efficiency_points,
    rotor_plane,
    step_response,
    torque_spectrum,
)
from drivegate_reports.page.style import PageFigure, page_figure

_KEPT: Final = 20
_OWN_WAY: Final = (
    " Blue, from the dot on: the candidate's currents at the ends of control periods, through runs without a load{}. "
    "Crosses: its eight operating points."
)
_RELEASE: Final = " (left), and with a torque reference out of reach and then none (right)"


@dataclass(frozen=True)
class ShownBehaviour:
    figures: tuple[PageFigure, ...]
    """Step, currents, torque and losses, as far as they were measured."""
    points: tuple[tuple[str, ...], ...]
    """A row for each operating point: point, torque, loss, least loss, excess, efficiency, d current, best d
    current."""


def prepare_behaviour(drive: DriveDocument) -> None:
    """Compute what the figures of every candidate on a drive show."""
    if contract_of(drive).has_behaviour:
        _trajectories(duty_document(drive))


def shown_behaviour(document: Mapping[str, Any], drive: DriveDocument) -> ShownBehaviour | None:
    """Draw how the candidate of a result behaves; None where that is not stated."""
    stated = document.get("behaviour")
    if not isinstance(stated, Mapping) or not contract_of(drive).has_behaviour:
        return None
    try:
        read = BehaviourSection.model_validate_json(json.dumps(stated))
    except (ValidationError, TypeError, ValueError):
        return None
    figures = tuple(_figures(read, duty_document(drive)))
    return ShownBehaviour(figures, tuple(_row(point) for point in read.points))


def _figures(read: BehaviourSection, drive: PmAcDocument) -> Iterator[PageFigure]:
    if read.step is not None:
        words = step_response.alternative(read.step), step_response.caption(read.step)
        yield page_figure("step", step_response.TITLE, partial(step_response.draw, read.step), *words)
    yield _plane(read, drive)
    if read.torque is not None:
        words = torque_spectrum.alternative(read.torque), torque_spectrum.caption(read.torque)
        drawn = partial(torque_spectrum.draw, read.torque)
        yield page_figure("torque-spectrum", torque_spectrum.TITLE, drawn, *words)
    if read.points:
        limit = 100.0 * limits_of(drive).loss_excess
        words = efficiency_points.alternative(read.points), efficiency_points.caption(limit)
        drawn = partial(efficiency_points.draw, read.points, limit)
        yield page_figure("efficiency-points", efficiency_points.TITLE, drawn, *words)


def _plane(read: BehaviourSection, drive: PmAcDocument) -> PageFigure:
    known, limit = _trajectories(drive), drive.rating.current_limit_a
    ways = [
        rotor_plane.Way(title, path.direct_current_a, path.quadrature_current_a)
        for title, path in (
            ("Through the range of speed", read.range),
            ("Into and out of weakening", read.release),
        )
        if path is not None
    ]
    dots = [(point.direct_current_a, point.quadrature_current_a) for point in read.points]
    own = _OWN_WAY.format("" if read.release is None else _RELEASE)
    words = rotor_plane.alternative(known, limit, ways), rotor_plane.caption(known) + own
    drawn = partial(rotor_plane.draw, known, limit, ways, dots)
    return page_figure("rotor-plane", rotor_plane.TITLE, drawn, *words)


@lru_cache(maxsize=_KEPT)
def _trajectories(drive: PmAcDocument) -> Mapping[str, Any]:
    return trajectories(drive)


def _row(point: EfficiencyPointSection) -> tuple[str, ...]:
    return (
        efficiency_points.name_of(point),
        figure(point.torque_nm),
        *_known(point.loss_w, point.least_loss_w, point.above_least_percent, point.efficiency_percent),
        figure(point.direct_current_a),
        *_known(point.least_loss_direct_a),
    )


def _known(*values: float | None) -> Sequence[str]:
    return ["–" if value is None else figure(value) for value in values]
