"""What kind of operating map is requested, over which axes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Final

from drivegate.studies.map.plan import MapAxes, axis_within, parameter_axis
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.candidate import Candidate
    from drivegate.studies.map.plan import MapPlan
    from drivegate_cases.drive.drive_document import DriveDocument

_SPEEDS: Final = {"points": "100:2000:39", "best": "550:2000:30", "loop": "550:2000:15"}
_TORQUES: Final = {"best": "1:25:25", "loop": "2:24:12"}


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
    # It brings the compiled plant, which axes that are refused do not need.
    from drivegate.studies.map.plan import PARAMETERS, MapPlan

    further = dict(parameter_axis(text, PARAMETERS) for text in parameters)
    if len(further) < len(parameters):
        raise InputError("--parameter names the same key twice, but each key has one axis")
    # Parameters vary slowest, so that each worker's points share one drive.
    return MapPlan(kind, drive, MapAxes.of({**further, **axes}), candidate)
