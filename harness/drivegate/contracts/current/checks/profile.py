"""Check that a search which declares so follows the paper's flowchart step by step."""

from __future__ import annotations

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check, judged_elsewhere
from drivegate_cases.drive.drive_document import DriveDocument


def _declares_no_flowchart(declaration: Declaration, _drive: DriveDocument) -> str | None:
    return (
        None
        if declaration.flowchart is not None
        else "the candidate does not declare the profile 'flowchart'"
    )


FLO_1 = Check(
    id="FLO-1",
    requirement=(
        "Every change of the advance angle follows the flowchart of Fig. 4 with the constants that the candidate "
        "declares, for any sequence of speeds and powers."
    ),
    source="P6",
    limit="exact",
    scenarios="scripts of Senses, for candidates of the profile 'flowchart'",
    formula="1 when every angle is one that Fig. 4 allows, else minus the distance to the nearest such angle / step",
    why="Whether a search is the published one does not show in where it ends; it shows in every decision.",
    evaluate=judged_elsewhere,
    reason_not_applicable=_declares_no_flowchart,
)
