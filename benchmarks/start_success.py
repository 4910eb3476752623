"""Draw which starts without a position sensor succeed, over 360 angles of the rotor, loads and inertias.

``python benchmarks/start_success.py docs/images/start-success.svg pm-ac-2kw-sensorless pm-ac-interior-sensorless``

Each start is one run of `foc-sensorless`, judged as by `SLS-1`. The nameplate states each inertia.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.builtin.duty_loading import SENSORLESS, DutyController
from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.contracts.duty.checks.sensorless.starting import SLS_1
from drivegate.contracts.duty.contract import DUTY
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.sensorless import WELL_ABOVE, least_rpm, sensorless_start
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.control_periods import first_period_from, period_start_s
from drivegate_models.pm_ac.closed_loop import prepared_duty_loop

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOADS: Final = (0.0, 0.25, 0.5)
"""Loads over rated torque (1)."""
INERTIAS: Final = (0.5, 1.0, 2.0)
"""Inertias over that of the drive (1)."""
_LONGER: Final = 1.05


def margins(drive: PmAcDocument, angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the margin of `SLS-1`, shape (inertias and loads, angles)."""
    controller = DutyController(SENSORLESS)
    rows = []
    for factor in INERTIAS:
        inertia = factor * drive.machine.inertia_kg_m2
        other = duty_document(drive.with_overrides([f"machine.inertia_kg_m2={inertia:.6g}"]))
        end = first_period_from(_LONGER * other.start_time_s, other.control_period_s)
        for load in LOADS:
            row = []
            for angle in angles:
                run = sensorless_start(other, least_rpm(other, WELL_ABOVE), load, float(angle))
                run = run.replaced(duration_s=period_start_s(end, other.control_period_s))
                record = DUTY.record(prepared_duty_loop, NOTHING_DECLARED, run, controller)
                margin = SLS_1.evaluate(record)
                assert margin is not None, run.name
                row.append(margin.value)
            rows.append(row)
    return np.array(rows)


def drawn(found: dict[str, NDArray[np.float64]], angles: NDArray[np.float64]) -> Figure:
    """Draw the margins of all drives over the rotor's angle; negative ones are starts that fail."""
    from matplotlib.figure import Figure

    names = [f"J × {inertia:g}, {100.0 * load:.0f} %" for inertia in INERTIAS for load in LOADS]
    figure = Figure(figsize=(8.0, 0.4 + 2.1 * len(found)), layout="constrained")
    for place, (name, values) in zip(
        np.atleast_1d(figure.subplots(len(found), 1, sharex=True)), found.items(), strict=True
    ):
        step = float(angles[1] - angles[0])
        edges = np.append(angles, angles[-1] + step)
        mesh = place.pcolormesh(
            edges, np.arange(len(names) + 1), values, vmin=-1.0, vmax=1.0, cmap="RdBu", rasterized=True
        )
        place.set_yticks(np.arange(len(names)) + 0.5, names, fontsize=7)
        place.invert_yaxis()
        place.set_title(f"{name}: {np.sum(values >= 0.0)} of {values.size} starts succeed", fontsize=9)
        figure.colorbar(mesh, ax=place, label="margin of SLS-1")
    place.set_xlabel("angle of the rotor (electrical degrees)")
    return figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("figure", type=Path)
    parser.add_argument("drives", nargs="+")
    parser.add_argument("--step", type=int, default=1, help="degrees between two angles of the rotor")
    given = parser.parse_args()
    angles = np.arange(0.0, 360.0, float(given.step))
    found = {}
    for name in given.drives:
        found[name] = margins(duty_document(load_drive(name)), angles)
        sys.stdout.write(f"{name}: {np.sum(found[name] >= 0.0)} of {found[name].size} starts succeed\n")
    from drivegate_reports.page.style import house_style, svg_document

    with house_style():
        write_atomically(given.figure, svg_document(drawn(found, angles), "start-success"))


if __name__ == "__main__":
    main()
