"""What `drivegate compare` and its page know of a contract: what is run, measured, tabulated, ranked and drawn."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

if TYPE_CHECKING:
    from drivegate.checks.check import Record
    from drivegate.containment.messages import Job
    from drivegate.contracts.drawings import Drawing
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.drive_cycle import DriveCycle
    from drivegate_cases.scenario.reference import Reference
    from drivegate_cases.scenario.scenario import Scenario

Row: TypeAlias = dict[str, Any]
"""A row of a table, or what was measured in one run: plain data."""
Document: TypeAlias = Mapping[str, Any]
"""The document of a comparison."""
Tone: TypeAlias = Literal["", "pass", "caution", "fail"]
"""How a cell is marked."""

POINTS: Final = "operating_points"
"""Table of the operating points: every comparison has it, with `held` in each row."""


@dataclass(frozen=True)
class ComparisonRequest:
    """What a comparison on one drive is made for."""

    drive: DriveDocument
    """The drive."""
    effort: str
    """``quick``, ``default`` or ``nightly``."""
    seed: int
    """Seed of everything drawn."""
    cycle: DriveCycle
    """The drive cycle."""
    reference: Reference = "torque"
    """What all candidates can follow: a torque, or else a speed."""


@dataclass(frozen=True)
class PlannedRun:
    """One run that every candidate makes."""

    group: str
    """What the run is for."""
    label: str
    """What it is, for people; the same label stands for repetitions with other noise."""
    scenario: Scenario
    """The scenario."""
    speed_rpm: float | None = None
    share: float | None = None
    """The operating point where it is one; share of rated power (1)."""
    change_s: float | None = None
    """When the disturbance is over (s)."""
    seed: int | None = None
    """Number of the repetition or draw."""


@dataclass(frozen=True)
class Figure:
    """A number of a row."""

    name: str
    """Its key."""
    label: str
    """What it is called; ``{first}`` stands for the first candidate of the ranking."""
    unit: str = ""
    """Its unit."""
    digits: int | None = 2
    """Digits after the point; None for four significant digits."""
    signed: bool = False
    """Whether a plus sign is written."""

    @property
    def heading(self) -> str:
        """Label and unit."""
        return f"{self.label} ({self.unit})" if self.unit else self.label


@dataclass(frozen=True)
class Words:
    """A column of words."""

    heading: str
    """Its heading."""
    write: Callable[[Row], str]
    """Return the words of a row."""
    tone: Callable[[Row], Tone] = lambda _: ""
    """Return how they are marked."""
    longest: int = 200
    """Characters that are shown at most."""


Column: TypeAlias = Figure | Words
"""A column of a table on a page."""


def name_of(key: str) -> Words:
    """Return the column of a key that has a name."""
    return Words(key, lambda row: str(row[key]), longest=80)


def held_column() -> Words:
    """Return the column that says whether a point is held."""
    return Words(
        "held", lambda row: "yes" if row["held"] else "no", lambda row: "" if row["held"] else "fail"
    )


@dataclass(frozen=True, kw_only=True)
class RunTable:
    """A table with what was measured in some of the runs."""

    name: str
    """Its name."""
    groups: tuple[str, ...]
    """The groups of runs that it has, one after another."""
    rows: Callable[[PlannedRun, Row, Row | None], Iterable[Row]]
    """From a run, its figures and the best possible there, return its rows."""
    columns: tuple[Column, ...] = ()
    """What the page shows of it."""
    caption: Callable[[Document], str] = lambda _: ""
    """Return what the page says about it."""
    shown: Callable[[Sequence[Row]], Sequence[Row]] = lambda rows: rows
    """Return the rows that the page shows."""


@dataclass(frozen=True)
class Summary:
    """A figure of a candidate over many rows."""

    name: str
    """Its key in the ranking."""
    value: Callable[[Sequence[Row]], float | None]
    """Return it; None where it is not known."""
    table: str = POINTS
    """The table of the rows; of operating points, those that are held."""


@dataclass(frozen=True)
class Excess:
    """A figure of an operating point, whose mean is compared with that of the best candidate."""

    figure: Figure
    """The figure; less is better."""
    above: str
    """Key of what a mean is above that of the best."""


@dataclass(frozen=True, kw_only=True)
class Ranking:
    """Who is first: fewest required checks failed, most operating points held, then the least mean of a figure."""

    rule: str
    """The rule in words, from the operating points on."""
    decides: str
    """The figure of operating points whose mean decides between equals."""
    at_shared: str = ""
    """Key of that mean over the points that all equals hold; empty where it is not kept."""
    place: tuple[str, str]
    """Keys that identify an operating point: speed and load."""
    count: str
    """Key of the number of operating points that could be held."""
    same_share: float = 0.0
    same_amount: float = 0.0
    """How far means may be apart that share a place, over the mean (1) and absolute."""
    summaries: tuple[Summary, ...]
    """What is known of each candidate."""
    against_first: tuple[Excess, ...] = ()
    """What is compared with the first candidate, over the points that both hold."""
    columns: tuple[Figure, ...]
    """What the page shows."""
    printed: tuple[str, ...]
    """Which of these the console shows."""
    caption: Callable[[str], str]
    """From the name of the first candidate, return what the page says about the ranking."""
    standing: Callable[[Row], Iterable[str]]
    """Return what is said of a candidate by itself, in clauses."""
    remark: str = ""
    """A remark for the console."""


@dataclass(frozen=True)
class Regions:
    """Bands of speed and of load, in each of which somebody wins."""

    ends_rpm: Callable[[DriveDocument], Sequence[float]]
    """Return the ends of the bands of speed (rpm)."""
    excesses: tuple[Excess, ...]
    """What is compared; the first decides."""


@dataclass(frozen=True)
class Population:
    """Repeated runs over which every two candidates are compared, with uncertainty."""

    where: str
    """Which runs these are; empty for each scenario by itself."""
    table: str
    """Their table."""
    contains: Callable[[Row], bool]
    """Return True for a row that belongs to them."""
    counts: str
    """Key of whether a run counts."""
    figures: tuple[Figure, ...]
    """What is compared."""


@dataclass(frozen=True)
class DrivePoint:
    """One operating point of a candidate on a drive, by which drives are compared."""

    speed_share: float
    """Share of the drive's range by which drives are compared (1)."""
    load_percent: float
    """Load over that of rated power, constant torque below base speed (%)."""
    speed_rpm: float
    torque_nm: float
    """Speed and load (rpm, N·m)."""
    held: bool
    """Whether the candidate holds it."""
    speed_mean_rpm: float
    torque_mean_nm: float
    """Means of the steady stretch (rpm, N·m)."""
    input_power_w: float
    current_sum_a: float
    """Means of input power and Σ|i| (W, A)."""
    ripple_percent: float
    """Torque ripple, peak to peak over mean (%)."""


@dataclass(frozen=True, kw_only=True)
class Section:
    """A section of the page."""

    name: str
    title: str
    link: str
    """Its anchor, its heading, and what links to it."""
    table: str
    """The table that it shows."""
    drawings: tuple[Drawing, ...] = ()
    """Its figures."""
    folded: str = ""
    """What opens the table where it is closed at first; empty where it is open."""
    words: Callable[[Document], Sequence[str]] = lambda _: ()
    """Return its paragraphs."""


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """How controllers of one contract are compared."""

    kind: str
    """Kind of the document."""
    ignores: str = ""
    """Why no drive cycle and no noise is run, in one clause; empty where they are."""
    plan: Callable[[ComparisonRequest], tuple[PlannedRun, ...]]
    """Return the runs of every candidate."""
    trace_every: Callable[[PlannedRun], int] = lambda _: 0
    """Return the control periods from one kept row of a run's trace to the next; 0 for no trace."""
    measure: Callable[[PlannedRun, Record], Row]
    """Return the figures of a run."""
    best: Callable[[Sequence[PlannedRun]], Mapping[tuple[str, float], Job[Any]]] = lambda _: {}
    """Return the jobs that find the best possible: by ``point`` and index of the run, and whatever else."""
    tables: tuple[RunTable, ...]
    """The tables of runs, the first of operating points."""
    best_tables: Callable[[Sequence[PlannedRun], Mapping[tuple[str, float], Any], Sequence[Row]], Row] = (
        lambda *_: {}
    )
    """From runs, the best possible and the rows of operating points, return the tables of the best possible."""
    curves: Mapping[str, tuple[str, str]]
    """For each key of the document with curves, their group of runs and their key among the figures."""
    ranking: Ranking
    regions: Regions | None = None
    populations: tuple[Population, ...] = ()
    """How candidates are compared."""
    facts: Callable[[ComparisonRequest, Sequence[PlannedRun]], Row]
    """Return what the document says about the comparison, among it `drive` and `size`."""
    supply_voltage_v: Callable[[DriveDocument], float]
    """Return a drive's nominal supply, as its kind states it (V)."""
    drive_points: Callable[[ComparisonRequest, Sequence[PlannedRun], Mapping[int, Row]], Iterator[DrivePoint]]
    """From the figures of a candidate, by the index of the run, return its points for a comparison of drives."""
    sections: tuple[Section, ...]
    """Sections of the page."""
    method: Callable[[Document], Sequence[str]]
    """Return how the comparison was made, in sentences."""
    shown_facts: Callable[[Document], Sequence[tuple[str, str]]]
    """Return names and values about the comparison."""


def mean_of(values: Iterable[float]) -> float | None:
    """Return the mean of values; None where there are none."""
    known = list(values)
    return math.fsum(known) / len(known) if known else None


def mean(key: str) -> Callable[[Sequence[Row]], float | None]:
    """Return the function of the mean of what is known of a figure."""
    return lambda rows: mean_of(row[key] for row in rows if row[key] is not None)


def worst(key: str) -> Callable[[Sequence[Row]], float | None]:
    """Return the function of the greatest value of a figure."""
    return lambda rows: max((row[key] for row in rows if row[key] is not None), default=None)


RANKING: Final = Section(name="ranking", title="Ranking", link="Ranking", table="ranking")
CHECKS: Final = Section(name="checks", title="Margins of the checks", link="Checks", table="checks")
TIMING: Final = Section(
    name="timing", title="Computing time and state", link="Computing time", table="timing"
)
"""Sections of every page."""
