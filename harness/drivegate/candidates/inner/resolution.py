"""From ``inner:pi:CANDIDATE`` to a candidate that answers with duty ratios."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from drivegate.candidates.candidate import Candidate, OuterLoop, hash_of
from drivegate.candidates.contract import ANSWERS
from drivegate.candidates.kinds import INNER_PREFIX
from drivegate.version import __version__
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.manifest import Manifest
    from drivegate_cases.documents.reach import Reach

_LOOPS: Final = ("pi",)
_OUTER: Final = "current"
_OWN: Final = "duty"
"""Contracts of the controller that is asked for current, and of the loop that follows it."""
_WAY: Final = "inner:pi:CANDIDATE, such as inner:pi:reference"


def from_text(specification: str) -> Candidate:
    """Find the candidate behind the loop, which may be of any kind."""
    # Which is found by the module that finds this one.
    from drivegate.candidates.resolution import resolve_candidate

    loop, _, named = specification.removeprefix(INNER_PREFIX).partition(":")
    if loop not in _LOOPS:
        raise InputError(
            f"the candidate '{one_line(specification)}' names the loop of currents '{one_line(loop)}', but there is "
            f"'{_LOOPS[0]}' only; write {_WAY}"
        )
    if not named:
        raise InputError(f"the candidate '{one_line(specification)}' names no controller; write {_WAY}")
    outer = resolve_candidate(named)
    if outer.contract not in (None, _OUTER):
        raise InputError(
            f"the candidate '{one_line(outer.name)}' answers with {ANSWERS[outer.contract]} itself; name it without "
            f"'{INNER_PREFIX}{loop}:'"
        )
    name = f"{INNER_PREFIX}{loop}:{outer.name}"
    return replace(
        outer,
        name=name,
        kind="inner",
        specification=specification,
        content_hash=hash_of((), f"drivegate {__version__} {INNER_PREFIX}{loop} {outer.content_hash}"),
        # It has no flowchart's scripts here. Its current loop takes no torque reference and does not read `enable`.
        declaration=replace(
            outer.declaration.with_bridge_on(),
            flowchart=None,
            references=("speed",),
            reverses=False,
            detects=(),
            current_bandwidth=None,
            modulation="continuous",
        ),
        details=OuterLoop(outer),
        # The one that its manifest names takes current references.
        drive=None,
        contract=_OWN,
    )


def from_manifest(manifest: Manifest, specification: str, reach: Reach) -> Candidate:  # noqa: ARG001  (as all kinds)
    """Refuse a manifest: the loop is put before a manifest's own name."""
    raise InputError(
        f"{shown_path(specification)}: the key 'kind' is 'inner', which has no manifest; write that of the controller "
        "itself, and inner:pi: before its path"
    )
