"""What the drive can do that a candidate was judged on, as the page shows it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from drivegate.drives.envelope_words import facts, required
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_reports.conformance.figures import drive_envelope
from drivegate_reports.page.figure import PageFigure
from drivegate_reports.page.printable import clean
from drivegate_reports.page.style import house_style, inline_svg


@dataclass(frozen=True)
class ShownDrive:
    """The drive of a result.

    Attributes
    ----------
    name : str
        Its name.
    facts : tuple of str
        Line of initial angles, times and what they mean for a controller, in sentences.
    required : tuple of str
        What is required of its controllers.
    figure : PageFigure
        What it can do over speed.
    """

    name: str
    facts: tuple[str, ...]
    required: tuple[str, ...]
    figure: PageFigure


def shown_drive(document: Mapping[str, Any], drive: DriveDocument) -> ShownDrive | None:
    """Draw what the drive of a result can do; None for a result of earlier versions, which does not tell it."""
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
        figure=PageFigure("drive-envelope", drive_envelope.TITLE, svg, *words),
    )


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."
