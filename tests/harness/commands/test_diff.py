"""`drivegate diff`: the first step at which two candidates differ, for people, for scripts and as a figure."""

import pytest

from drivegate_cases.scenario.scenario import load_scenario

CONTROLLERS = """
from drivegate import Command

class One:
    def reset(self, nameplate): self.steps = 0
    def step(self, sense):
        self.steps += 1
        return Command(self.reference(), 0.25 if sense.speed > 53 else 0.0)
    def reference(self): return 5.0

class Other(One):
    def reference(self): return 5.000000000000001 if self.steps > 120 else 5.0

class Raising(One):
    def reference(self): raise ValueError("[red]no[/red]")
"""

FIELDS = ("current_reference", "advance_angle", "input_power")


@pytest.fixture
def files(tmp_path):
    (tmp_path / "mine.py").write_text(CONTROLLERS, encoding="utf-8")
    short = load_scenario("lock-up").replaced(duration_s=0.5)
    (tmp_path / "short.json").write_text(short.to_json(), encoding="utf-8")


def diff(command, one, other, *words):
    return command("diff", f"mine.py:{one}", f"mine.py:{other}", "--case", "short.json", *words)


def test_equal_candidates_end_with_0(command, files):
    ended = diff(command, "One", "One")
    assert ended.code == 0
    assert "EQUAL in all 1000 steps" in ended.out


def test_the_first_difference_is_shown_in_full(command, files):
    ended = diff(command, "One", "Other", "--before", 1)
    assert ended.code == 1
    assert "DIFFERENT first in step 120, at 0.06 s" in ended.out
    assert "5.000000000000001" in ended.out, "numbers must be shown to the last digit"
    assert "+8.88e-16 (1 ULP)" in ended.out
    assert "phase_currents[5]" in ended.out
    assert "electrical angle" in ended.out
    assert "--plot difference.svg" in ended.out


def test_the_document_has_what_a_script_needs(command, files, tmp_path):
    ended = diff(command, "One", "Other", "--before", 2, "--plot", "x.svg", "--json")
    document = ended.document
    found = document["difference"]
    assert (ended.code, document["exit_code"], document["verdict"]) == (1, 1, "different")
    assert [candidate["name"] for candidate in document["candidates"]] == ["mine.py:One", "mine.py:Other"]
    assert (document["steps_equal"], document["steps_planned"], found["step"]) == (120, 1000, 120)
    assert [step["step"] for step in found["before"]] == [118, 119]
    reference, angle, power = found["commands"]
    assert (reference["ulps"], reference["differs"], angle["differs"]) == (1, True, False)
    assert (reference["first_bits"], reference["second_bits"]) == ("4014000000000000", "4014000000000001")
    assert power["first"] is None, "NaN has no place in JSON"
    assert len(found["sense"]["phase_currents"]) == len(found["plant"]["phase_currents"]) == 5
    assert document["files"] == ["x.svg"]
    assert "<svg" in (tmp_path / "x.svg").read_text(encoding="utf-8")


def test_the_drive_can_be_altered_and_small_differences_allowed(command, files):
    allowed = diff(command, "One", "Other", "--tolerance", "1e-12", "--set", "inertia_kg_m2=0.1", "--json")
    assert (allowed.code, allowed.document["verdict"], allowed.document["tolerance"]) == (0, "equal", 1e-12)
    ignored = diff(command, "One", "Other", "--ignore", "current_reference")
    assert ignored.code == 0


@pytest.mark.parametrize(
    ("one", "other", "place"), [("Raising", "One", "first"), ("One", "Raising", "second")]
)
def test_a_fault_of_either_ends_with_1(command, files, one, other, place):
    text, data = diff(command, one, other), diff(command, one, other, "--json")
    assert (text.code, data.code) == (1, 1)
    assert f"EXCEPTION of the {place}, mine.py:Raising: ValueError: [red]no[/red]" in text.out
    fault = data.document["fault"]
    assert (fault["place"], fault["kind"], fault["step"]) == (place, "exception", 0)
    assert data.document["verdict"] == "exception"


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["nobody", "reference", "--case", "lock-up"], "'nobody' is unknown"),
        (["reference", "missing.py:Mine", "--case", "lock-up"], "missing.py does not exist"),
        (["reference", "--case", "lock-up"], "SECOND"),
        (["reference", "initial"], "--case"),
        (["reference", "initial", "--case", "lock-upp"], "'lock-up'"),
        (["reference", "initial", "--case", "lock-up", "--tolerance", "-1"], "from 0 upward"),
        (["reference", "initial", "--case", "lock-up", "--plot", "x.pdf"], ".png or .svg"),
        (["reference", "initial", "--case", "lock-up", "--ignore", "power"], "input_power"),
        (
            [
                "reference",
                "initial",
                "--case",
                "lock-up",
                *(word for field in FIELDS for word in ("--ignore", field)),
            ],
            "no field to compare",
        ),
    ],
)
def test_bad_input_is_refused_in_one_sentence(refused, words, reason):
    assert reason in refused("diff", *words)
