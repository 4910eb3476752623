"""The page of a controller of duty ratios: how it behaves, and what its drive can do."""

from __future__ import annotations

import copy
from html import unescape
from typing import Any

import pytest

from drivegate.output.causes import likely_causes_of
from drivegate.output.continuous_integration import escaped, markdown
from drivegate.results.sections import BehaviourSection
from drivegate_cases.documents.wording import figure
from drivegate_cases.publication import open_assumptions
from drivegate_reports.conformance.behaviour import shown_behaviour
from drivegate_reports.conformance.coverage import drive_of
from drivegate_reports.conformance.figures import duty_envelope, efficiency_points, rotor_plane, step_response
from drivegate_reports.conformance.report import page
from drivegate_reports.page.page import clean
from drivegate_reports.page.style import house_style

Document = dict[str, Any]


@pytest.fixture(scope="module")
def text(duty_result: Document) -> str:
    return page(duty_result)


def section_of(document: Document) -> BehaviourSection:
    import json

    return BehaviourSection.model_validate_json(json.dumps(document["behaviour"]))


def test_each_figure_stands_with_its_words(duty_result: Document, text: str) -> None:
    for name in (
        "step",
        "rotor-plane",
        "torque-spectrum",
        "efficiency-points",
        "drive-envelope",
        "drive-plane",
    ):
        assert text.count(f'<figure class="card" id="{name}"') == 1, name
    stated = section_of(duty_result)
    assert stated.step is not None
    assert stated.torque is not None
    assert f"overshoots by {figure(stated.step.overshoot_percent)} % of the step" in text
    assert f"90 % is reached after {stated.step.rise_ms:.4g} ms" in text
    assert f"a ripple of {figure(stated.torque.peak_to_peak_percent)} % of rated torque" in text
    assert text.count(" % speed, ") >= 16, "eight operating points in the figure's words and in the table"
    assert "undistorted phase voltage 55.43 V (peak), reached at the current limit from 585.42 rpm on" in text
    assert len(text) < 1_000_000


def test_where_the_drive_s_values_come_from_stands_in_place_of_what_is_assumed_of_the_paper_s(
    text: str,
) -> None:
    assert "<code>machine.resistance_ohm</code>" in text
    assert 'data-name="assumptions"' in text
    taken = {item.statement for item in open_assumptions() if item.statement in text}
    assert not taken, "said of a drive that is not the paper's"


def test_the_same_document_gives_the_same_bytes(duty_result: Document, text: str) -> None:
    assert page(copy.deepcopy(duty_result)) == text


def test_overshoot_and_rise_time_are_marked(duty_result: Document) -> None:
    step = section_of(duty_result).step
    assert step is not None
    with house_style():
        torque, _ = step_response.draw(step).axes
        slow, _ = step_response.draw(step.model_copy(update={"rise_ms": None})).axes
    written = [text.get_text() for text in torque.texts]
    assert f"overshoot {figure(step.overshoot_percent)} %" in written
    assert f"90 % in {step.rise_ms:.4g} ms" in written
    assert not any(text.get_text().startswith("90 %") for text in slow.texts)
    assert "90 % is not reached" in step_response.alternative(step.model_copy(update={"rise_ms": None}))


def test_the_currents_stand_between_circle_and_ellipses(duty_result: Document) -> None:
    drive = drive_of(duty_result)
    shown = shown_behaviour(duty_result, drive)
    assert shown is not None
    plane = next(drawn for drawn in shown.figures if drawn.name == "rotor-plane")
    assert "within a circle of 26 A" in plane.alternative
    assert "dashed at 550 rpm, dotted at 1650 rpm" in plane.caption
    assert "Through the range of speed: d current from" in plane.alternative


def test_a_drive_without_field_weakening_has_one_ellipse_and_no_way_out_of_weakening(
    duty_result: Document,
) -> None:
    drive = drive_of(duty_result)
    behaviour = duty_result["behaviour"] | {"release": None}
    unweakened = drive.replaced(highest_speed_rpm=drive.rating.base_speed_rpm)
    shown = shown_behaviour(duty_result | {"behaviour": behaviour}, unweakened)
    assert shown is not None
    plane = next(drawn for drawn in shown.figures if drawn.name == "rotor-plane")
    assert "dashed at 550 rpm. Green" in plane.caption
    assert "(right)" not in plane.caption
    assert "weakening" not in plane.alternative


def test_losses_far_above_the_least_stand_out(duty_result: Document) -> None:
    first, *others = section_of(duty_result).points
    costly = first.model_copy(update={"above_least_percent": 63.0})
    unknown = others[0].model_copy(update={"above_least_percent": None})
    with house_style():
        (panel,) = efficiency_points.draw([costly, unknown, *others[1:]], 5.0).axes
    colours = [bar.get_facecolor() for bar in panel.patches]
    assert colours[0] != colours[2]
    assert [text.get_text() for text in panel.texts][:2] == ["63 %", "not known"]


@pytest.mark.parametrize(
    "stated",
    [
        None,
        "<script>alert(1)</script>",
        {"step": {"speed_rpm": "<script>alert(1)</script>"}},
        {"range": {}, "release": {}, "points": [{"loss_w": "<script>alert(1)</script>"}]},
    ],
)
def test_whatever_else_stands_there_is_not_shown(duty_result: Document, stated: object) -> None:
    text = page(duty_result | {"behaviour": stated})
    assert 'id="behaviour"' not in text
    assert "alert(1)" not in text


def test_a_name_of_a_scenario_is_escaped(duty_result: Document) -> None:
    changed = copy.deepcopy(duty_result)
    changed["behaviour"]["range"]["scenario"] = "<script>alert(1)</script>"
    assert "<script>alert(1)" not in page(changed)


def test_a_drive_without_any_torque_in_reach_is_reported_so() -> None:
    point = {"speed_rpm": 0.0, "greatest_torque_nm": None, "greatest_power_w": None}
    empty = {"rating": {}, "points": [point, point | {"speed_rpm": 10.0}], "efficiency_map": {}}
    assert "No torque is within the limits" in duty_envelope.alternative(empty)


def test_the_plane_of_a_drive_alone_has_one_panel(duty_result: Document) -> None:
    from drivegate.contracts.duty.best_operation import trajectories
    from drivegate_cases.drive.pm_ac.document import PmAcDocument

    drive = drive_of(duty_result)
    assert isinstance(drive, PmAcDocument)
    with house_style():
        assert len(rotor_plane.draw(trajectories(drive), 26.0, ()).axes) == 1


def test_a_typical_failure_names_its_likely_causes(duty_result: Document, text: str) -> None:
    assert "ikely cause" not in text, "nothing fails"
    failed = copy.deepcopy(duty_result)
    check = failed["checks"][0]
    check |= {
        "verdict": "fail",
        "counterexample": check["scenario"],
        "measured": "overshoot 14.9 % from 0 to 1 N·m",
    }
    text = page(failed)
    assert "Likely cause 1 of 2: the gains of the current regulator are too high" in text
    # The summary for CI servers names the same causes.
    summary = markdown(failed | {"corpus_runs": 0, "baseline": None})
    for words in likely_causes_of(failed):
        assert escaped(words) in summary
        assert clean(words)[1:] in unescape(text)
