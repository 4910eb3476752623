"""An operating map before it is computed: its kind, the axes of its grid, and the plant at each point."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, prod
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from drivegate.candidates.candidate import Candidate
from drivegate.scenarios.parameters import DRIVE_KEYS, SCALES
from drivegate_cases.documents.problems import described
from drivegate_cases.documents.wording import nearest, one_line, shown
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.plant import Scales
from drivegate_models.errors import InputError

MOST_POINTS: Final = 20_000_000
"""Points of a map at most."""
_FEWEST = 2
_MOST_VALUES = 100_000
_RANGE_PARTS = 3
SPEED: Final = "speed_rpm"
TORQUE: Final = "torque_nm"
ADVANCE: Final = "advance_deg"
CURRENT: Final = "current_a"
PARAMETERS: Final = (*SCALES, *DRIVE_KEYS)
"""Parameters that may be further axes of a map."""

BEST_COLUMNS: Final = (
    "edge_deg",
    "advance_deg",
    "current_reference_a",
    "current_sum_a",
    "input_power_w",
    "shaft_power_w",
    "efficiency",
)
"""What the best angle gives at a speed and a torque; all NaN where no angle reaches the torque."""
LOOP_COLUMNS: Final = (
    "convergence_margin",
    "speed_error_rpm",
    "advance_deg",
    "current_reference_a",
    "current_sum_a",
    "least_current_sum_a",
    "excess_percent",
    "input_power_w",
    "shaft_power_w",
    "efficiency",
    "torque_ripple_percent",
    "current_peak_a",
)
"""What a candidate makes of a speed and a torque; all NaN where no angle reaches the torque, or after a fault."""
CONVERGED: Final = "converged"
NOT_CONVERGED: Final = "not converged"
NOT_FEASIBLE: Final = "not feasible"

_SPEEDS: Final = {"points": "100:2000:39", "best": "550:2000:30", "loop": "550:2000:15"}
_TORQUES: Final = {"best": "1:25:25", "loop": "2:24:12"}
_POINTS_AT_ONCE: Final = {"points": 20_000, "best": 16, "loop": 8}


@dataclass(frozen=True)
class MapAxes:
    """The axes of a map, the last of which varies fastest."""

    names: tuple[str, ...]
    """Names of the axes, with their units."""
    values: tuple[tuple[float, ...], ...]

    @classmethod
    def of(cls, axes: Mapping[str, Sequence[float]]) -> MapAxes:
        made = cls(tuple(axes), tuple(tuple(values) for values in axes.values()))
        if made.points > MOST_POINTS:
            raise InputError(f"the map has {made.points} points, but must have at most {MOST_POINTS}")
        return made

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(len(values) for values in self.values)

    @property
    def points(self) -> int:
        return prod(self.shape)

    def coordinates(self, first: int, last: int) -> dict[str, NDArray[np.float64]]:
        places = np.unravel_index(np.arange(first, last), self.shape)
        return {
            name: np.asarray(values, dtype=np.float64)[place]
            for name, values, place in zip(self.names, self.values, places, strict=True)
        }


def axis_within(lowest: float, highest: float, *, above: bool = False) -> Callable[[str], tuple[float, ...]]:
    """Make a reader of axes whose values lie within limits."""

    def read(text: str) -> tuple[float, ...]:
        values = _values(text)
        if values is None:
            raise InputError(
                f"it is {shown(text)}, but must be LOW:HIGH:COUNT with LOW below HIGH and a COUNT from "
                f"{_FEWEST} to {_MOST_VALUES}, a list such as 700,1000,1500, or a number"
            )
        if len(set(values)) < len(values):
            raise InputError(f"it is {shown(text)}, which has a value twice")
        wrong = [value for value in values if not lowest <= value <= highest or (above and value == lowest)]
        if wrong:
            raise InputError(
                f"it has {wrong[0]:g}, but must be {'above' if above else 'from'} {lowest:g}"
                f"{' and up' if above else ''} to {highest:g}"
            )
        return values

    return read


def _values(text: str) -> tuple[float, ...] | None:
    try:
        if ":" in text:
            parts = text.split(":")
            count = int(parts[2]) if len(parts) == _RANGE_PARTS else 0
            low, high = float(parts[0]), float(parts[1])
            if not _FEWEST <= count <= _MOST_VALUES or not (isfinite(low) and isfinite(high)) or low >= high:
                return None
            return tuple(float(value) for value in np.linspace(low, high, count))
        values = tuple(float(part) for part in text.split(","))
    except (ValueError, IndexError):
        return None
    return values if all(map(isfinite, values)) else None


def parameter_axis(text: str, known: Sequence[str]) -> tuple[str, tuple[float, ...]]:
    key, equals, axis = text.partition("=")
    if not equals:
        raise InputError(f"--parameter {shown(text)} is no axis, which is written KEY=LOW:HIGH:COUNT")
    if key not in known:
        raise InputError(
            f"--parameter {one_line(text)}: '{one_line(key)}' is no parameter of a map, the nearest is "
            f"'{nearest(key, known)}'"
        )
    try:
        return key, axis_within(-1e9, 1e9)(axis)
    except InputError as error:
        raise InputError(f"--parameter {one_line(text)}: {error}") from error


@dataclass(frozen=True)
class MapPlan:
    """A map, before it is computed."""

    kind: str
    """Steady states over speed, angle and current; the best angle over speed and torque; or closed-loop runs.
    """
    drive: DriveDocument
    axes: MapAxes
    candidate: Candidate | None = None
    """Whose closed-loop runs."""

    @property
    def columns(self) -> tuple[str, ...]:
        if self.kind == "points":
            from drivegate_models.steady.grid import POINT_COLUMNS

            return POINT_COLUMNS
        return {"best": BEST_COLUMNS, "loop": LOOP_COLUMNS}[self.kind]

    def pieces(self) -> list[tuple[int, int]]:
        length = _POINTS_AT_ONCE[self.kind]
        points = self.axes.points
        return [(first, min(first + length, points)) for first in range(0, points, length)]


def map_kind(candidate: str | None, texts: Mapping[str, str | None]) -> str:
    """State the kind of map from the candidate and the axes that are given."""
    if candidate is None and texts["torque_nm"] is None:
        return "points"
    if texts["advance_deg"] is not None or texts["current_a"] is not None:
        raise InputError(
            "--advance-deg and --current-a go with a map of the plant, without a candidate and without --torque-nm"
        )
    return "best" if candidate is None else "loop"


def map_axes(kind: str, texts: Mapping[str, str | None]) -> dict[str, tuple[float, ...]]:
    """Read the axes of a kind of map; one that is not given has its default."""
    readers: dict[str, tuple[Callable[[str], tuple[float, ...]], str]] = {
        "speed_rpm": (axis_within(0.0, 1e5, above=True), _SPEEDS[kind])
    }
    if kind == "points":
        readers["advance_deg"] = (axis_within(0.0, 90.0), "0:90:46")
        readers["current_a"] = (axis_within(0.0, 1e5), "2:26:13")
    else:
        readers["torque_nm"] = (axis_within(0.0, 1e6, above=kind == "best"), _TORQUES[kind])
    axes = {}
    for name, (read, default) in readers.items():
        try:
            axes[name] = read(texts[name] or default)
        except InputError as error:
            raise InputError(f"--{name.replace('_', '-')}: {error}") from error
    return axes


def planned_map(
    kind: str,
    drive: DriveDocument,
    candidate: Candidate | None,
    axes: Mapping[str, Sequence[float]],
    parameters: Sequence[str],
) -> MapPlan:
    """Plan a map with the axes of parameters added."""
    further = dict(parameter_axis(text, PARAMETERS) for text in parameters)
    if len(further) < len(parameters):
        raise InputError("--parameter names the same key twice, but each key has one axis")
    # Parameters vary slowest, so that each worker's points share one drive.
    return MapPlan(kind, drive, MapAxes.of({**further, **axes}), candidate)


def plant_of(drive: DriveDocument, values: dict[str, float]) -> tuple[DriveDocument, Scales]:
    own = [f"{key}={value:.17g}" for key, value in values.items() if key in DRIVE_KEYS]
    changed = drive.with_overrides(own)
    try:
        # Scales are a table of a scenario, which checks them.
        return changed, Scales(**{key: value for key, value in values.items() if key in SCALES})
    except ValidationError as error:
        raise InputError(f"--parameter: {described(error, Scales)}") from error


def drives_of(
    plan: MapPlan, at: dict[str, NDArray[np.float64]]
) -> Iterator[tuple[slice, DriveDocument, Scales]]:
    """Cut points where a parameter changes, so that each stretch has one plant."""
    names = [name for name in plan.axes.names if name in PARAMETERS]
    length = len(at[SPEED])
    starts = [0]
    if names:
        table = np.column_stack([at[name] for name in names])
        starts += (np.flatnonzero((table[1:] != table[:-1]).any(axis=1)) + 1).tolist()
    for start, end in zip(starts, [*starts[1:], length], strict=True):
        drive, scales = plant_of(plan.drive, {name: float(at[name][start]) for name in names})
        yield slice(start, end), drive, scales
