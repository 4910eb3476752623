"""A reviewer's own requirements: by which checks they are shown, and what is refused."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest
from tests.harness.made import made_outcome

from drivegate.candidates.declaration import Declaration
from drivegate.gate.own_requirements import require_fitting, with_evidence
from drivegate.output.continuous_integration import junit_xml
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.requirements.file import read_requirements
from drivegate_models.errors import InputError

TEXT = """\
schema = 1

[[evidence]]
id = "SYS-42"
checks = ["STP-1", "DEC-1"]

[[evidence]]
id = "SYS-43"
checks = ["STP-1"]
"""


def read(tmp_path: Path, text: str = TEXT) -> Declaration:
    file = tmp_path / "requirements.toml"
    file.write_text(text, encoding="utf-8")
    declaration = Declaration(requirements=read_requirements(file))
    require_fitting(declaration, load_drive("pm-ac-interior"))
    return declaration


def test_each_check_has_the_requirements_that_it_is_evidence_for(tmp_path: Path) -> None:
    outcomes = [made_outcome(check, "pass") for check in ("STP-1", "DEC-1", "ACC-1")]
    shown = [one.evidence_for for one in with_evidence(outcomes, read(tmp_path))]
    assert shown == [("SYS-42", "SYS-43"), ("SYS-42",), ()]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('"DEC-1"', '"DEC1"'), "SYS-42 names the check 'DEC1', but must name one that there is"),
        (("SYS-43", "SYS-42"), "two tables [[evidence]] have the id SYS-42; put the checks into one list"),
        (('checks = ["STP-1"]', "checks = []"), "evidence[1].checks"),
        (("[[evidence]]\nid", "[[evidences]]\nid"), "evidence"),
    ],
)
def test_mistakes_get_one_sentence(change: tuple[str, str], words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        read(tmp_path, TEXT.replace(*change))
    assert words in str(refused.value)
    assert "requirements.toml" in str(refused.value)


def test_ci_servers_get_them_as_properties() -> None:
    result = {
        "candidate": {"name": "own"},
        "faults": [],
        "baseline": None,
        "timing": {},
        "checks": [made_outcome("STP-1", "pass").model_dump() | {"evidence_for": ["SYS-42"]}],
    }
    cases = ElementTree.fromstring(junit_xml(result)).iter("testcase")
    case = next(case for case in cases if case.get("name") == "STP-1")
    assert [item.attrib for item in case.iter("property")] == [{"name": "requirement", "value": "SYS-42"}]
