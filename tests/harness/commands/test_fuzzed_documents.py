"""Damaged documents of every kind are read or refused in one short sentence, never with a fault of drivegate."""

from __future__ import annotations

import _ctypes
import json
import os
import random
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import pytest

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.manifest import Manifest
from drivegate.candidates.resolution import resolve_candidate
from drivegate.gate.own_requirements import require_fitting
from drivegate.output.failure import ExitCode, Failure, failure_of
from drivegate.output.report_writers import LoadWriter
from drivegate.output.result_file import counterexamples
from drivegate.output.result_reports import OWN_FORMATS, read_result, write_reports_again
from drivegate.results.baseline import read_baseline
from drivegate.results.counterexample import read_counterexample
from drivegate.results.result import content_hash
from drivegate.results.waivers import read_waivers
from drivegate.studies.campaign.file import read_campaign
from drivegate.studies.drive.fit import read_measured
from drivegate.studies.verify import verification
from drivegate_cases.documents.document import read_document
from drivegate_cases.documents.wording import LONGEST_MESSAGE
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.requirements.file import read_requirements
from drivegate_cases.scenario.drive_cycle import load_drive_cycle
from drivegate_cases.scenario.operating_point import load_operating_point, load_power_sweep
from drivegate_cases.scenario.scenario import load_scenario

Tree = dict[str, Any]
DRAWS: Final = int(os.environ.get("DRIVEGATE_TEST_DRAWS", "40"))
"""Damaged documents of each kind; more of them for a hunt."""
FORMATS: Final[dict[str, LoadWriter]] = {
    name: (lambda write=write: write) for name, write in OWN_FORMATS.items()
}
NESTED: Final = "nested"
"""Stands for a list of very many levels, which JSON's own writer refuses."""
DEEP: Final = "[" * 100_000 + "]" * 100_000
VALUES: Final = (
    None, True, False, 0, -1, 1, 3, 0.5, 1e308, -1e308, 5e-324, 10**400, -(2**63), float("nan"), float("inf"),
    "", "x", "x" * 3000, "\x1b[31m\n\ud800", "paper-5-phase", "pm-ac-surface", [], {}, [[]], [0, "x", None],
    {"x" * 3000: {"y" * 3000: 1}}, {"kind": "pm-ac"}, [[0.0, 1.0], [1.0, 0.0]], NESTED, ["x"] * 3000,
)  # fmt: skip


def copied(value: Any) -> Any:
    return json.loads(json.dumps(value))


def keys_of(outer: Any) -> list[Any]:
    return list(outer) if isinstance(outer, dict) else list(range(len(outer)))


def place_in(tree: Any, source: random.Random) -> tuple[Any, Any]:
    """Go down from the top at random: keys near it are met as often as one of thousands of recorded numbers."""
    while True:
        key = source.choice(keys_of(tree))
        value = tree[key]
        if not (isinstance(value, (dict, list)) and value and source.random() < 0.7):
            return tree, key
        tree = value


def damaged(document: Tree, source: random.Random) -> str:
    """Delete, replace, swap, repeat and add at random; of some documents the text itself is damaged."""
    tree = copied(document)
    for _ in range(source.choice((1, 1, 1, 2, 4))):
        if not tree:
            break
        outer, key = place_in(tree, source)
        action = source.choice(("delete", "replace", "replace", "replace", "swap", "repeat", "add"))
        if action == "delete":
            del outer[key]
        elif action == "replace":
            outer[key] = copied(source.choice(VALUES))
        elif action == "swap":
            other, place = place_in(tree, source)
            outer[key] = copied(other[place])
        elif action == "repeat":
            outer[key] = [copied(outer[key])] * source.choice((2, 3, 1000))
        elif isinstance(outer, dict):
            name = source.choice(("x", "x" * 3000, "schema", "kind", str(key).upper()))
            outer[name] = copied(source.choice(VALUES))
    text = json.dumps(tree).replace(f'"{NESTED}"', DEEP)
    if source.random() < 0.1:
        place = source.randrange(len(text))
        text = (
            text[:place] + source.choice(("", "{", "]", '"', "\\", "1e999", "NaN", "\0")) + text[place + 1 :]
        )
    return text


def ended(work: Callable[[Path], object], path: Path) -> Failure:
    """Return how a command ends that does the work with a file."""
    try:
        work(path)
    except Exception as error:
        return failure_of(error)
    return Failure("", ExitCode.PASSED)


def reported(path: Path) -> None:
    """Read a result and make its reports, as ``drivegate report`` does."""
    folder = path.with_suffix("")
    folder.mkdir(exist_ok=True)
    write_reports_again(read_result(path), path, folder, FORMATS)


def verified(path: Path) -> None:
    verification(path)


WAIVER: Final = {
    "check": "CNV-1",
    "candidate": "foc",
    "reason": "r",
    "owner": "o",
    "expires": "2040-01-31",
    "margin": -1.0,
}
CAMPAIGN: Final = {
    "schema": 1, "name": "many", "candidates": ["reference"], "cases": ["lock-up"], "checks": ["CNV-1"], "draws": 3,
    "grid": {"speed_rpm": [500.0, 1000.0]},
    "spread": {"resistance": {"kind": "normal", "mean": 1.0, "sigma": 0.1, "lowest": 0.8, "highest": 1.2}},
}  # fmt: skip
MANIFEST: Final = {
    "schema": 1,
    "name": "mine",
    "kind": "builtin",
    "entry": "reference",
    "drive": "paper-5-phase",
}


@pytest.fixture
def result(command: Any, failing: Any) -> Tree:
    """A result with everything that can be reported."""
    assert command("check", "published", "--output", "first").code == 1
    document: Tree = json.loads(Path("first/result.json").read_text(encoding="utf-8"))
    scenario = load_scenario("lock-up").to_mapping()
    document["fixed"] = [{"name": "lock-up", "scenario": scenario, "margins": {"CNV-1": 0.5}}]
    document["traces"] = [{"time_s": [0.0, 1.0], "speed_rpm": [0.0, 1.0]}]
    return with_hash(document)


def with_hash(document: Tree) -> Tree:
    document["provenance"]["content_hash"] = content_hash(document)
    return document


def fuzz(document: Tree, work: Callable[[Path], object], folder: Path, *, hashed: bool = False) -> None:
    codes, wrong = set(), {}
    for seed in range(DRAWS):
        text = damaged(document, random.Random(seed))
        if hashed and seed % 2:
            with suppress(Exception):
                text = json.dumps(with_hash(json.loads(text)))
        path = folder / "damaged.json"
        path.write_text(text, encoding="utf-8")
        failure = ended(work, path)
        codes.add(failure.exit_code)
        short = len(failure.message) <= LONGEST_MESSAGE and failure.message.isprintable()
        if failure.exit_code not in (ExitCode.PASSED, ExitCode.REFUSED) or not short:
            wrong.setdefault(failure.message[-120:], (seed, text[:2000]))
    assert not wrong
    assert ExitCode.REFUSED in codes


OWN: Final[Tree] = {
    "schema": 1,
    "requirement": [
        {
            "id": "REQ-1",
            "text": "It is back in time.",
            "when": {"event": "step of load", "speed_rpm": [1.0, 2.0], "direction": "forward"},
            "between_periods": [1.0, 9.0],
            "for_s": 0.1,
            "quantity": "speed_deviation_rpm",
            "statistic": "time until",
            "until": [-1.0, 1.0],
            "at_most": 3.0,
        }
    ],
    "scenario": [
        {
            "name": "step",
            "duration_s": [0.5, 0.6],
            "restarts_s": [0.1, [0.2, 0.3]],
            "speed_rpm": [[0.0, [500.0, 1500.0]]],
            "load": {"kind": "constant_torque", "torque_nm": 0.1, "factor": [[0.0, 0.0]]},
        }
    ],
}


KINDS: Final[dict[str, tuple[Callable[[], Tree], Callable[[Path], object]]]] = {
    "drive": (lambda: load_drive("paper-5-phase").to_mapping(), load_drive),
    "drive of duty ratios": (lambda: load_drive("pm-ac-interior").to_mapping(), load_drive),
    "scenario": (lambda: load_scenario("lock-up").to_mapping(), load_scenario),
    "point": (lambda: load_operating_point("fig6-torque-1500").to_mapping(), load_operating_point),
    "sweep": (lambda: load_power_sweep("fig7-input-current").to_mapping(), load_power_sweep),
    "cycle": (lambda: load_drive_cycle("ece-15").to_mapping(), load_drive_cycle),
    "waivers": (lambda: {"schema": 1, "waiver": [WAIVER]}, lambda path: read_waivers(path, ("foc",))),
    "campaign": (lambda: CAMPAIGN, read_campaign),
    "requirements": (
        lambda: OWN,
        lambda path: require_fitting(
            Declaration(requirements=read_requirements(path)), load_drive("pm-ac-interior")
        ),
    ),
    "manifest": (lambda: MANIFEST, lambda path: read_document(path, Manifest)),
}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_document_is_read_or_refused_in_a_short_sentence(kind: str, tmp_path: Path) -> None:
    valid, read = KINDS[kind]
    path = tmp_path / "valid.json"
    path.write_text(json.dumps(valid()), encoding="utf-8")
    assert ended(read, path).exit_code == ExitCode.PASSED, ended(read, path).message
    fuzz(valid(), read, tmp_path)


OF_A_RESULT: Final[dict[str, Callable[[Path], object]]] = {
    "report": reported,
    "verify": verified,
    "baseline": read_baseline,
}


@pytest.mark.parametrize("work", OF_A_RESULT)
def test_a_damaged_result_is_used_or_refused_in_a_short_sentence(
    work: str, result: Tree, tmp_path: Path
) -> None:
    path = tmp_path / "valid.json"
    path.write_text(json.dumps(result), encoding="utf-8")
    assert ended(OF_A_RESULT[work], path).exit_code == ExitCode.PASSED, ended(OF_A_RESULT[work], path).message
    fuzz(result, OF_A_RESULT[work], tmp_path, hashed=True)


def test_a_damaged_counterexample_is_read_or_refused_in_a_short_sentence(
    result: Tree, tmp_path: Path
) -> None:
    fuzz(counterexamples(result)[0], read_counterexample, tmp_path)


def damaged_bytes(content: bytes, source: random.Random) -> bytes:
    """Cut, overwrite, repeat and insert bytes at random."""
    for _ in range(source.choice((1, 1, 2, 8))):
        place = source.randrange(len(content) + 1)
        length = source.choice((1, 4, 64, len(content)))
        inserted = source.choice(
            (b"", source.randbytes(length), b"\xff" * 8, b"\0" * 8, b"," * 3000, content)
        )
        content = content[:place] + inserted + content[place + source.choice((0, len(inserted), length)) :]
    return content


MEASURED: Final = b"speed_rpm,current_a,advance_deg,torque_nm\n500,10,0,8.5\n1500,12,30,9.1\n1500,,45,7.0\n"


@pytest.mark.parametrize("name", ["measured.csv", "library.so"])
def test_damaged_bytes_are_read_or_refused_in_a_short_sentence(name: str, tmp_path: Path) -> None:
    content, read = {
        "measured.csv": (MEASURED, read_measured),
        "library.so": (Path(_ctypes.__file__).read_bytes(), lambda path: resolve_candidate(str(path))),
    }[name]
    path = tmp_path / name
    for seed in range(DRAWS):
        path.write_bytes(damaged_bytes(content, random.Random(seed)))
        failure = ended(read, path)
        assert failure.exit_code in (ExitCode.PASSED, ExitCode.REFUSED), (seed, failure)
        assert len(failure.message) <= LONGEST_MESSAGE, (seed, failure)
        assert failure.message.isprintable() or not failure.message, (seed, failure)
