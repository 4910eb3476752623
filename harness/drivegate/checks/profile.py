"""Check that a search which declares so follows the paper's flowchart step by step."""

from __future__ import annotations

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check, judged_elsewhere


def _declares_no_flowchart(declaration: Declaration) -> str | None:
    return (
        None
        if declaration.flowchart is not None
        else "the candidate does not declare the profile 'flowchart'"
    )


FLO_1 = Check(
    "FLO-1",
    "Every change of the advance angle follows the flowchart of Fig. 4 with the constants that the candidate "
    "declares, for any sequence of speeds and powers.",
    "P6",
    "candidate",
    "required",
    "exact",
    "scripts of Senses, for candidates of the profile 'flowchart'",
    "1 when every angle is one that Fig. 4 allows, else minus the distance to the nearest such angle / step",
    "Whether a search is the published one does not show in where it ends; it shows in every decision.",
    judged_elsewhere,
    _declares_no_flowchart,
)
