"""What decides how a candidate is checked; light enough for the command line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from drivegate.gate.focus import WHOLE, Focus

if TYPE_CHECKING:
    from drivegate.containment.watches import SlowRun
    from drivegate.results.baseline import Baseline
    from drivegate.results.counterexample import Counterexample
    from drivegate.results.waivers import Waiver
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.requirements.file import OwnRequirements


@dataclass(frozen=True, kw_only=True)
class CheckOptions:
    """How a candidate is checked, and which earlier records are taken into account."""

    drive: DriveDocument | None = None
    """The drive; None for the one that the candidate's manifest names, else the default."""
    drive_named: str | None = None
    """The string that named the drive, which the result repeats."""
    effort: str = "default"
    """``quick``, ``default`` or ``nightly``."""
    seed: int = 0
    workers: int | None = None
    """Number of processes; None for as many as there are processors."""
    max_time: float | None = None
    """Time after which no more work is begun (s)."""
    search: bool = True
    """Whether the search climbs toward small margins."""
    corpus: Sequence[Counterexample] = ()
    """Counterexamples that are run again."""
    baseline: Baseline | None = None
    """Earlier result that margins are compared with."""
    waivers: Sequence[Waiver] = ()
    requirements: OwnRequirements | None = None
    """The user's own requirements; None for those that the candidate's manifest names."""
    fail_on: Literal["required", "advisory"] = "required"
    """``required``, or ``advisory`` where advisory checks count like required ones."""
    contested: Literal["pass", "fail"] = "pass"
    """``fail`` where failures count that no known good controller avoids in the same scenario, else ``pass``."""
    focus: Focus = WHOLE
    on_slow: Callable[[SlowRun], None] | None = None
    """Called with a run that will take long."""
    is_ended: Callable[[], bool] = lambda: False
    """Once it returns True, the check ends with what its runs have shown by then."""
