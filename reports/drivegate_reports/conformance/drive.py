"""What the drive can do that a candidate was judged on, as the page shows it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any, Final

from drivegate.drives.abilities import ability_of
from drivegate.drives.kinds import kind_of
from drivegate.results.result import finite
from drivegate_cases.drive.data_sheet import origin
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_reports.conformance.figures import drive_envelope, duty_envelope, rotor_plane
from drivegate_reports.page.page import clean
from drivegate_reports.page.style import PageFigure, page_figure

_KEPT: Final = 20


@dataclass(frozen=True)
class ShownDrive:
    name: str
    facts: tuple[str, ...]
    """Line of initial angles, times and what they mean for a controller, in sentences."""
    required: tuple[str, ...]
    figures: tuple[PageFigure, ...]
    """What it can do over speed, and of a PM AC drive where in the plane of d and q current."""


def shown_drive(document: Mapping[str, Any], drive: DriveDocument) -> ShownDrive | None:
    """Draw what the drive of a result can do; None for a result of earlier versions, which does not state it."""
    return _drawn(json.dumps(finite(document.get("envelope"))), drive)


@lru_cache(maxsize=_KEPT)
def _drawn(envelope_text: str, drive: DriveDocument) -> ShownDrive | None:
    ability, envelope = ability_of(drive), json.loads(envelope_text)
    if not envelope and not kind_of(drive).has_angles:
        # Results of such drives leave it out.
        envelope = finite(ability.envelope(drive, lambda _: None))
    if not envelope:
        return None
    draw_figures = _FIGURES.get(drive.contract)
    return ShownDrive(
        name=clean(drive.name),
        facts=tuple(_sentence(words) for words in ability.facts(envelope)),
        required=tuple(_sentence(words) for words in ability.required(drive)),
        figures=() if draw_figures is None else draw_figures(envelope, drive),
    )


@dataclass(frozen=True)
class StatedValue:
    """A value of a drive, and where it comes from."""

    key: str
    """Its table and key in the drive's document."""
    value: str
    source: str
    """What the document says of it."""


def stated_values(drive: DriveDocument) -> tuple[StatedValue, ...]:
    """List the values of which a drive's document says where they come from."""
    tables = drive.to_mapping()
    return tuple(
        StatedValue(f"{table}.{key}", clean(str(value)), clean(origin(sentence, value)))
        for table, sentences in drive.provenance.items()
        for key, sentence in sentences.items()
        if (value := tables[table].get(key)) is not None
    )


def _over_speed(envelope: Mapping[str, Any], drive: DriveDocument) -> tuple[PageFigure, ...]:
    limit = 100.0 * limits_of(drive).ripple
    words = drive_envelope.alternative(envelope), drive_envelope.caption(envelope, limit)
    drawn = partial(drive_envelope.draw, envelope, limit)
    return (page_figure("drive-envelope", drive_envelope.TITLE, drawn, *words),)


def _over_speed_and_in_plane(envelope: Mapping[str, Any], drive: DriveDocument) -> tuple[PageFigure, ...]:
    known, limit = envelope["trajectories"], drive.rating.current_limit_a
    over_speed, plane = partial(duty_envelope.draw, envelope), partial(rotor_plane.draw, known, limit, ())
    words = duty_envelope.alternative(envelope), duty_envelope.caption(envelope)
    of_plane = rotor_plane.alternative(known, limit, ()), rotor_plane.caption(known)
    return (
        page_figure("drive-envelope", duty_envelope.TITLE, over_speed, *words),
        page_figure("drive-plane", rotor_plane.TITLE, plane, *of_plane),
    )


_FIGURES: Final = {"current": _over_speed, "duty": _over_speed_and_in_plane}
"""What draws the envelope of a drive, by the name of its contract."""


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."
