"""What the drive can do that a candidate was judged on, as the page shows it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from drivegate.drives.envelope_words import facts, required
from drivegate.drives.pm_ac_envelope import pm_ac_envelope
from drivegate.drives.pm_ac_words import pm_ac_facts, pm_ac_required
from drivegate.results.result import finite
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_reports.conformance.figures import drive_envelope, duty_envelope, rotor_plane
from drivegate_reports.page.figure import PageFigure
from drivegate_reports.page.printable import clean
from drivegate_reports.page.style import house_style, inline_svg


@dataclass(frozen=True)
class ShownDrive:
    """The drive of a result."""

    name: str
    """Its name."""
    facts: tuple[str, ...]
    """Line of initial angles, times and what they mean for a controller, in sentences."""
    required: tuple[str, ...]
    """What is required of its controllers."""
    figures: tuple[PageFigure, ...]
    """What it can do over speed, and of a PM AC drive where in the plane of d and q current."""


def shown_drive(document: Mapping[str, Any], drive: DriveDocument) -> ShownDrive | None:
    """Draw what the drive of a result can do; None for a result of earlier versions, which does not tell it."""
    if isinstance(drive, PmAcDocument):
        return _shown_pm_ac(drive)
    envelope = document.get("envelope")
    if not envelope:
        return None
    limit = 100.0 * limits_of(drive).ripple
    with house_style():
        svg = inline_svg(drive_envelope.draw(envelope, limit), "drive-envelope")
    words = drive_envelope.alternative(envelope), drive_envelope.caption(envelope, limit)
    return ShownDrive(
        name=clean(drive.name),
        facts=tuple(_sentence(words) for words in facts(envelope)),
        required=tuple(_sentence(words) for words in required(drive)),
        figures=(PageFigure("drive-envelope", drive_envelope.TITLE, svg, *words),),
    )


@dataclass(frozen=True)
class StatedValue:
    """A value of a drive, and where it comes from."""

    key: str
    """Its table and key in the drive's document."""
    value: str
    """The value, in the unit that the key names."""
    source: str
    """What the document says of it."""


def stated_values(drive: DriveDocument) -> tuple[StatedValue, ...]:
    """List the values of which a drive's document says where they come from."""
    tables = drive.to_mapping()
    return tuple(
        StatedValue(f"{table}.{key}", clean(str(tables[table][key])), clean(sentence))
        for table, sentences in drive.provenance.items()
        for key, sentence in sentences.items()
        if tables[table].get(key) is not None
    )


def _shown_pm_ac(drive: PmAcDocument) -> ShownDrive:
    envelope = finite(pm_ac_envelope(drive))
    known, limit = envelope["trajectories"], drive.rating.current_limit_a
    with house_style():
        over_speed = inline_svg(duty_envelope.draw(envelope), "drive-envelope")
        plane = inline_svg(rotor_plane.draw(known, limit, ()), "drive-plane")
    words = duty_envelope.alternative(envelope), duty_envelope.caption(envelope)
    of_plane = rotor_plane.alternative(known, limit, ()), rotor_plane.caption(known)
    return ShownDrive(
        name=clean(drive.name),
        facts=tuple(_sentence(words) for words in pm_ac_facts(envelope)),
        required=(_sentence(pm_ac_required(drive)),),
        figures=(
            PageFigure("drive-envelope", duty_envelope.TITLE, over_speed, *words),
            PageFigure("drive-plane", rotor_plane.TITLE, plane, *of_plane),
        ),
    )


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."
