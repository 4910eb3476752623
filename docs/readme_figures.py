"""The figures of read-me and documentation: ``python docs/readme_figures.py FOLDER``."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.drive.drive_document import load_drive
from drivegate_lab.paper.figures import input_current, search_trajectory
from drivegate_models.errors import InputError
from drivegate_reports.page.style import house_style, new_figure, svg_document

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def _failed_step() -> Figure:
    """Draw the moment at which a slow current loop fails STP-1."""
    from drivegate.candidates.resolution import resolve_candidate
    from drivegate.containment.judge import own_candidate
    from drivegate.contracts.catalogue import check_of, contract_of
    from drivegate.contracts.duty.document import duty_document
    from drivegate.contracts.duty.scenarios.building import torque_scenario
    from drivegate.contracts.recorded_trace import deciding_moment
    from drivegate.drives.running import recorded
    from drivegate.output.panels import draw_moment

    drive = duty_document(load_drive("pm-ac-interior"))
    loaded = own_candidate(resolve_candidate("faulty:slow-currents"))
    record = recorded(loaded, torque_scenario(drive, 0.0, (0.0, 1.0)), loaded.controller())
    check, contract = check_of("duty", "STP-1"), contract_of(drive)
    moment = deciding_moment(check, record, check.evaluate(record))
    figure, (panel,) = new_figure(2.6, 1)
    draw_moment(panel, moment, contract.recorded_signals(record.run), contract.panels_of(record.scenario))
    return figure


README_FIGURES: Final[Mapping[str, Callable[[], Figure]]] = {
    "failed-step": _failed_step,
    "search-trajectory": lambda: search_trajectory.draw(search_trajectory.search_trajectory()),
    "initial-against-optimal": lambda: input_current.draw(input_current.input_current_sweep()),
}
"""How each figure is drawn, by the name of its file."""


def write_readme_figures(folder: Path) -> tuple[Path, ...]:
    """Write the figures of the read-me."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder {folder} cannot be made: {error.strerror}; name one in a writable folder"
        ) from error
    paths = []
    for name, draw in README_FIGURES.items():
        with house_style():
            text = svg_document(draw(), name)
        path = folder / f"{name}.svg"
        write_atomically(path, text)
        paths.append(path)
    return tuple(paths)


def main(arguments: Sequence[str]) -> int:
    """Write the figures into the folder that the command line names."""
    if len(arguments) != 1:
        sys.stderr.write("usage: python docs/readme_figures.py FOLDER\n")
        return 2
    try:
        paths = write_readme_figures(Path(arguments[0]))
    except InputError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    sys.stdout.write("".join(f"{path}\n" for path in paths))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
