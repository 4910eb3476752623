"""What `drivegate compare` and its page know of a contract: what is run, measured, tabulated, ranked and drawn."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

if TYPE_CHECKING:
    from pandas import DataFrame, Series

    from drivegate.checks.check import Record
    from drivegate.containment.messages import Job
    from drivegate.contracts.drawings import Drawing, Values
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.drive_cycle import DriveCycle
    from drivegate_cases.scenario.reference import Reference
    from drivegate_cases.scenario.scenario import Scenario

Row: TypeAlias = dict[str, Any]
"""A row of a table, or what was measured in one run: plain data."""
Document: TypeAlias = Mapping[str, Any]
"""The document of a comparison."""
Aggregate: TypeAlias = "str | Callable[[Series[Any]], float]"
"""What makes one number of many: a function, or its name in pandas."""
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
    above: str = ""
    """Key of the difference from the mean of another candidate; ``{}`` stands for ``first`` or ``best``."""

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


HELD: Final = Words(
    "held", lambda row: "yes" if row["held"] else "no", lambda row: "" if row["held"] else "fail"
)
"""The column that says whether a point is held."""


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
    summaries: Mapping[str, Mapping[str, tuple[Values, Aggregate]]]
    """For each table, the figures of a candidate over all its rows: key, values and what makes one number of them;
    of operating points, those that are held."""
    costs: tuple[Figure, ...] = ()
    """Figures of operating points, less being better, that are compared with those of the first candidate over the
    points that both hold, and with the least in each region; the first decides."""
    columns: tuple[Figure, ...]
    """What the page shows."""
    printed: tuple[str, ...] = ()
    """Which of these the console shows; empty for all."""
    caption: Callable[[str], str]
    """From the name of the first candidate, return what the page says about the ranking."""
    standing: Callable[[Row], Iterable[str]]
    """Return what is said of a candidate by itself, in clauses."""
    remark: str = ""
    """A remark for the console."""


@dataclass(frozen=True)
class Population:
    """Repeated runs over which every two candidates are compared, with uncertainty."""

    where: str
    """Which runs these are; empty for each scenario by itself."""
    table: str
    """Their table."""
    contains: Callable[[DataFrame], Series[bool]]
    """From the table, return which rows belong to them."""
    counts: str
    """Key of whether a run counts."""
    figures: tuple[Figure, ...]
    """What is compared."""


DRIVE_POINT: Final = (
    *("speed_share", "load_percent", "speed_rpm", "torque_nm", "held"),
    *("speed_mean_rpm", "torque_mean_nm", "input_power_w", "current_sum_a", "ripple_percent"),
)
"""Keys of an operating point by which drives are compared: its share of the drive's range of speeds and its load, of
rated power at constant torque below base speed; speed and load themselves; whether it is held, and means of the steady
stretch. Ripple is peak to peak over mean torque."""


@dataclass(frozen=True, kw_only=True)
class Section:
    """A section of the page."""

    name: str
    title: str
    link: str = ""
    """Its anchor, its heading, and what links to it, where that is not the heading."""
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
    region_ends_rpm: Callable[[DriveDocument], Sequence[float]] | None = None
    """Return the ends of the bands of speed, in each of which somebody wins (rpm); None for no regions."""
    populations: tuple[Population, ...] = ()
    """How candidates are ranked, and compared with uncertainty."""
    facts: Callable[[ComparisonRequest, Sequence[PlannedRun]], Row]
    """Return what the document says about the comparison, among it `drive` and `size`."""
    supply_voltage_v: Callable[[DriveDocument], float]
    """Return a drive's nominal supply, as its kind states it (V)."""
    drive_points: Callable[[ComparisonRequest, Sequence[PlannedRun], Mapping[int, Row]], Iterable[Row]]
    """From the figures of a candidate, by the index of the run, return its points for a comparison of drives, with
    the keys of `DRIVE_POINT`."""
    sections: tuple[Section, ...]
    """Sections of the page."""
    method: Callable[[Document], Sequence[str]]
    """Return how the comparison was made, in sentences."""
    shown_facts: Callable[[Document], Sequence[tuple[str, str]]]
    """Return names and values about the comparison."""


def mean_of(values: Series[Any]) -> float:
    """Return the mean of the known values, whose order does not matter; NaN where none is known."""
    known = values.dropna()
    return math.fsum(known) / len(known) if len(known) else math.nan


RANKING: Final = Section(name="ranking", title="Ranking", table="ranking")
CHECKS: Final = Section(name="checks", title="Margins of the checks", link="Checks", table="checks")
TIMING: Final = Section(
    name="timing", title="Computing time and state", link="Computing time", table="timing"
)
"""Sections of every page."""
