"""`drivegate checks` and `drivegate cases`: what there is, and where it comes from."""

from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate_cases.drive.drive_document import drive_names
from drivegate_cases.scenario.drive_cycle import cycle_names
from drivegate_cases.scenario.operating_point import operating_point_names, power_sweep_names
from drivegate_cases.scenario.scenario import scenario_names


def test_checks_are_listed_with_their_requirements(command):
    listed = command("checks", "--json").document["checks"]
    assert [row["id"] for row in listed] == [check.id for check in CHECKS]
    assert all(set(row) >= {"id", "requirement", "source", "subject", "level", "limit"} for row in listed)
    text = command("checks").out
    assert all(check.id in text for check in CHECKS)


def test_cases_are_listed_by_the_names_that_other_commands_take(command):
    document = command("cases", "--json").document
    names = {
        "scenarios": scenario_names(),
        "operating_points": operating_point_names(),
        "sweeps": power_sweep_names(),
        "drive_cycles": cycle_names(),
        "drives": drive_names(),
    }
    text = command("cases").out
    for key, known in names.items():
        assert [row["name"] for row in document[key]] == list(known)
        assert all(row["description"] for row in document[key])
        assert all(name in text for name in known)
    supplies = {row["name"]: row["description"].rpartition(", ")[2] for row in document["drives"]}
    assert supplies["paper-5-phase"] == "2 × 48 V"
    assert supplies["star-3-phase"] == supplies["pm-ac-surface"] == "96 V", (
        "a link without a tap is no two halves"
    )


def test_an_argument_too_many_is_refused(refused):
    assert "extra" in refused("cases", "extra")


def test_one_check_is_explained_with_its_limit_on_the_drive_formula_and_causes(command, refused):
    (row,) = command("checks", "stp-1", "--drive", "pm-ac-servo", "--json").document["checks"]
    assert (row["id"], row["drive"]) == ("STP-1", "pm-ac-servo")
    shown = "the gains of the current regulator are too high"
    assert any(cause.startswith(shown) for cause in row["likely_causes"]), row["likely_causes"]
    text = command("checks", "STP-1").out
    for key in ("requirement", "limit", "formula"):
        assert f"{key}: " in text
    assert "likely cause: the current regulator is too slow" in text
    assert "next: drivegate check CANDIDATE --only STP-1" in text
    family = command("checks", "FWK", "--json").document["checks"]
    assert [row["id"] for row in family] == ["FWK-1", "FWK-2", "FWK-3"]
    both = command("checks", "PWR-1", "--json").document["checks"]
    assert [row["drive"] for row in both] == ["paper-5-phase", "pm-ac-interior"]
    assert "the nearest is 'STP-1'" in refused("checks", "STP-2")
    assert "is not judged by STP-1" in refused("checks", "STP-1", "--drive", "paper-5-phase")


def test_checks_are_those_of_the_drive_of_the_manifest_in_this_folder(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    manifest = tmp_path / "candidate.toml"
    words = 'schema = 1\nname = "mine"\nkind = "python"\nentry = "mine.py:Mine"\ndrive = "pm-ac-surface"\n'
    manifest.write_text(words, encoding="utf-8")
    listed = command("checks", "--json").document["checks"]
    assert "STP-1" in {row["id"] for row in listed}, "not those of the paper's drive"
    own = command("help", "FWK-2").out
    assert own.startswith("FWK-2 on pm-ac-surface")
    assert "next: drivegate check --only FWK-2\n" in own
    other = command("help", "FWK-2", "--drive", "pm-ac-2kw").out
    assert "next: drivegate check CANDIDATE --only FWK-2 --drive pm-ac-2kw\n" in other
    # The command line wins, and checks of the other contract are explained on a drive of theirs.
    manifest.write_text(words + '[check]\ndrive = "pm-ac-msl"\n', encoding="utf-8")
    assert command("checks", "FWK-2").out.startswith("FWK-2 on pm-ac-msl")
    assert command("checks", "CNV-1").out.startswith("CNV-1 on paper-5-phase")


def test_help_of_a_command_and_of_a_check_is_also_asked_for_by_a_word(command):
    assert command("help").out == command("--help").out
    assert command("help", "check").out == command("check", "--help").out
    assert command("help", "STP-1").out == command("checks", "STP-1").out
    assert "the nearest is 'STP-1'" in command("help", "STP1").err


def test_a_number_that_is_none_is_called_a_whole_number(command):
    assert "'abc' is not a valid whole number" in command("check", "foc", "--seed", "abc").err
