"""What failed checks have in common: named once, with the checks, and first to be mended."""

from __future__ import annotations

import copy
import io
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import pytest

from drivegate.output.causes import causes_of, first_to_mend
from drivegate.output.console import console_for
from drivegate.output.continuous_integration import junit_xml, markdown
from drivegate.output.explanations import by_urgency
from drivegate.studies.check.checked import Checked
from drivegate.studies.check.display import show_checked
from drivegate_reports.conformance.view import page_values

EDGE = "the search takes the angle past the feasible edge, and the speed is lost"


@pytest.fixture
def three_failed(recorded: dict[str, Any]) -> dict[str, Any]:
    """A result in which a check of its own fails first, then two whose runs lose the speed in the same way."""
    document = copy.deepcopy(recorded)
    lost = document["checks"][0]
    alone = copy.deepcopy(lost) | {"id": "CMD-1", "recording": None}
    document["checks"] = [document["checks"][1] | {"id": "ADV-1"}, alone, lost, lost | {"id": "CPW-1"}]
    return document


def shown(document: dict[str, Any], folder: Path) -> str:
    stream = io.StringIO()
    show_checked(console_for(stream), Checked("mine.py:Mine", None, document, folder))
    return stream.getvalue()


def test_checks_whose_runs_lose_the_speed_in_the_same_way_have_one_cause(
    three_failed: dict[str, Any],
) -> None:
    (cause,) = causes_of(three_failed)
    assert str(cause) == f"{EDGE}: in the counterexamples of CNV-1, CPW-1"


def test_what_one_check_shows_alone_is_no_common_cause(recorded: dict[str, Any]) -> None:
    assert causes_of(recorded) == ()


def test_the_cause_stands_before_the_table_and_next_points_at_it(
    three_failed: dict[str, Any], tmp_path: Path
) -> None:
    text = shown(three_failed, tmp_path)
    assert text.index(EDGE) < text.index("margin"), "the cause must be named first"
    assert text.count(EDGE) == 1
    following = next(line for line in text.splitlines() if line.startswith("next: "))
    assert "CNV-1.json" in following, "CMD-1 fails alone, two checks have the cause of CNV-1"
    values = page_values(three_failed)
    assert values["meaning"].endswith(
        "The search" + EDGE.removeprefix("the search") + ": in the counterexamples of CNV-1, CPW-1."
    )
    assert "CNV-1.json" in values["next_step"], "the page and the terminal begin with the same check"
    assert markdown(three_failed).index("past the feasible edge") < markdown(three_failed).index("| check |")


def test_junit_begins_a_message_with_the_cause(three_failed: dict[str, Any]) -> None:
    cases = ElementTree.fromstring(junit_xml(three_failed)).iter("testcase")
    messages = {case.get("name"): case[0].get("message", "") for case in cases}
    for check in ("CNV-1", "CPW-1"):
        assert messages[check].startswith(f"{EDGE} (common cause of CNV-1, CPW-1); "), messages[check]
    assert EDGE not in messages["CMD-1"], "a check that fails alone has no common cause"


def test_failed_rows_come_first_in_the_order_of_the_catalogue(three_failed: dict[str, Any]) -> None:
    assert [check["id"] for check in by_urgency(three_failed["checks"])] == [
        "CMD-1",
        "CNV-1",
        "CPW-1",
        "ADV-1",
    ]


def test_a_stall_is_reported_as_one(three_failed: dict[str, Any]) -> None:
    for trace in three_failed["traces"]:
        trace["speed_rpm"] = [*trace["speed_rpm"][:-20], *[0.0] * 20]
    assert causes_of(three_failed)[0].words == "the motor stalls"


def test_non_determinism_is_mended_first(three_failed: dict[str, Any]) -> None:
    three_failed["checks"].append(three_failed["checks"][1] | {"id": "DET-1"})
    first = first_to_mend(three_failed)
    assert first is not None
    assert first["id"] == "DET-1"


def test_a_fault_without_failed_checks_is_what_next_names(recorded: dict[str, Any], tmp_path: Path) -> None:
    document = copy.deepcopy(recorded)
    document["checks"] = document["checks"][1:]
    document["faults"] = [
        {
            "kind": "crash",
            "phase": "step",
            "message": "died",
            "error": "",
            "traceback": "",
            "step": 3,
            "time_s": 0.1,
            "sense": None,
        }
    ]
    document["checks"][0] |= {"verdict": "inconclusive", "runs": 0}
    name = document["checks"][0]["id"]
    text = shown(document, tmp_path)
    assert "next: mend what is named first (crash), then drivegate check mine.py:Mine" in text
    assert text.index("crash: died") < text.index(f"not judged: {name}") < text.index("margin")
    assert f"Not judged: {name}." in page_values(document)["meaning"]
