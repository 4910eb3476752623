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
