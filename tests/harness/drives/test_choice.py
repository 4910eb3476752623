"""Which drive a candidate is judged on: the one that is named, its manifest's, or the default."""

from dataclasses import replace
from pathlib import Path

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.kinds import common_drive, drive_for
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError

PAPER = load_drive("paper-5-phase")
MINE = PAPER.replaced(name="mine", resistance_ohm=0.1)
OTHER = PAPER.replaced(name="other", resistance_ohm=0.2)
PLAIN = resolve_candidate("reference")


def test_a_named_drive_wins_over_a_manifest_s_and_that_over_the_default() -> None:
    candidate = replace(PLAIN, drive=MINE)
    assert drive_for(candidate, OTHER) == OTHER
    assert drive_for(candidate) == MINE
    assert drive_for(PLAIN) == drive_for(None) == PAPER


@pytest.mark.parametrize(("name", "drive"), [("reference", "pm-ac-interior"), ("foc", "star-3-phase")])
def test_a_candidate_of_one_contract_is_refused_on_a_drive_of_the_other(name: str, drive: str) -> None:
    with pytest.raises(InputError, match=r"name a drive such as .* with --drive") as refused:
        drive_for(resolve_candidate(name), load_drive(drive))
    assert "\n" not in str(refused.value)
    assert drive_for(resolve_candidate("foc")).name == "pm-ac-interior", "each contract has a default drive"


def test_candidates_are_compared_on_one_drive() -> None:
    mine, other = replace(PLAIN, drive=MINE), replace(PLAIN, drive=OTHER)
    assert common_drive([mine, mine]) == MINE
    assert common_drive([mine, other], PAPER) == PAPER
    with pytest.raises(
        InputError, match="name the drives 'mine' and 'other', but candidates are compared on one"
    ):
        common_drive([mine, other])


def test_a_manifest_names_a_drive_beside_it(tmp_path: Path) -> None:
    (tmp_path / "mine.json").write_text(MINE.to_json(), encoding="utf-8")
    manifest = tmp_path / "candidate.toml"
    lines = 'schema = 1\nname = "tuned"\nkind = "builtin"\nentry = "initial"\n'
    manifest.write_text(lines + 'drive = "mine.json"\n', encoding="utf-8")
    assert resolve_candidate(str(manifest)).drive == MINE
    manifest.write_text(lines, encoding="utf-8")
    assert resolve_candidate(str(manifest)).drive is None
    manifest.write_text(lines + 'drive = "none.toml"\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"in the key 'drive', .*none\.toml does not exist"):
        resolve_candidate(str(manifest))
