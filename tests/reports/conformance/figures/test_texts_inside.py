"""No text of a figure leaves it, also where ticks and labels are wide."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from drivegate.checks.course import course_of
from drivegate.checks.margin import Mark, Moment, Point
from drivegate.contracts.contract import RecordedTrace
from drivegate.contracts.duty.columns import DutyColumns
from drivegate.contracts.recorded_trace import columns_of
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_reports.conformance.figures import closeup, duty_run
from drivegate_reports.page.style import house_style, keep_inside

TIME = np.linspace(0.0, 1.5, 300)
# Ticks of eight characters and more on each axis.
SCALES = {"speed_rpm": 1e-4, "torque_nm": 1e-5, "peak_current_a": 123456.789, "voltage_v": 99999.5}


def columns() -> dict[str, np.ndarray]:
    names = (*DutyColumns.recorded_names, *DutyColumns.further_names)
    waves = {name: SCALES.get(name, -1e3) * (1.0 + 1e-3 * np.sin(9.0 * TIME)) for name in names}
    return {**waves, "time_s": TIME}


def trace(case: str) -> RecordedTrace:
    names = DutyColumns.recorded_names
    read = columns_of({name: values.tolist() for name, values in columns().items()}, names)
    assert read is not None
    return RecordedTrace(load_scenario(case), read, (0.5, 1.0))


def moment(column: str) -> Moment:
    value = SCALES[column]
    return Moment(
        start_s=0.5,
        end_s=1.0,
        column=column,
        origin_s=0.5,
        levels=(Mark(words="a limit that is written in many words", value=1.001 * value),),
        instants=(Mark(words="12.34 ms allowed", value=0.5), Mark(words="too late", value=1.0)),
        point=Point(words=f"{value:.6g} of a long unit", time_s=0.7, value=value),
    )


def two_courses(quantity: str) -> Moment:
    courses = [course_of(name, TIME, 1e-5 * np.sin(TIME + place)) for place, name in enumerate("ab")]
    return Moment(start_s=0.0, end_s=1.5, quantity=quantity, courses=tuple(courses))


DRAWN: dict[str, Callable[[], Figure]] = {
    **{
        f"closeup of {column}": partial(
            lambda column: closeup.draw(moment(column), columns(), DutyColumns.panels), column
        )
        for column in SCALES
    },
    **{
        f"closeup of courses, {quantity}": partial(
            lambda quantity: closeup.draw(two_courses(quantity), columns(), DutyColumns.panels), quantity
        )
        for quantity in ("torque, ideal regulator (N·m)", "turn towards the reference (el. deg)")
    },
    "run with torques": lambda: duty_run.draw(trace("pm-ac-torque-step")),
    "run with speeds": lambda: duty_run.draw(trace("pm-ac-speed-step")),
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", DRAWN)
def test_no_text_leaves_the_figure(name: str) -> None:
    with house_style():
        figure = DRAWN[name]()
        keep_inside(figure)
        renderer = FigureCanvasAgg(figure).get_renderer()
        width, height = figure.get_size_inches() * figure.dpi
        for panel in figure.axes:
            low, high = sorted(panel.get_ylim())
            ticks = [text for text in panel.get_yticklabels() if low <= text.get_position()[1] <= high]
            texts = [*panel.texts, panel.xaxis.label, panel.yaxis.label, *ticks]
            for text in texts:
                box = text.get_window_extent(renderer)
                if text.get_text() and text.get_visible() and box.width > 0.0:
                    inside = (
                        box.x0 >= -0.5 and box.x1 <= width + 0.5 and box.y0 >= -0.5 and box.y1 <= height + 0.5
                    )
                    assert inside, f"{text.get_text()!r} is at {box.x0:.0f} to {box.x1:.0f} of {width:.0f}"
        assert all(panel.get_position().width > 0.35 for panel in figure.axes), "the panels have room"


@pytest.mark.parametrize(
    ("case", "has_reference"), [("pm-ac-torque-step", True), ("pm-ac-speed-step", False)]
)
def test_a_torque_reference_is_drawn_where_the_controller_has_one(case: str, has_reference: bool) -> None:
    from drivegate.contracts.catalogue import contract_of

    scenario = load_scenario(case)
    lines = [line for panel in contract_of(scenario.drive).panels_of(scenario) for line in panel.lines]
    assert ("torque_reference_nm" in {line.column for line in lines}) is has_reference
    assert ("load_torque_nm" in {line.column for line in lines}) is not has_reference
