"""The list of results is the same for the same code, and shows what has to show."""

import json
import tomllib
from pathlib import Path

import pytest

import proof_rows
from drivegate_cases.drive.drive_document import load_drive
from drivegate_lab.selftest.subjects import FAULTS_OF, chosen_faults
from proof_text import Places, normal, parts_of, stripped, words_of
from unchanged_results import Listing

PLACES = Places((("/scratch", "{scratch}"), ("/clone", "{code}")))
HASH = "6ea88350f05a5789"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        (f"sources {HASH}, report: /scratch/a.json", "sources {hash}, report: {scratch}/a.json"),
        ("91 runs, 69 s, report: a", "91 runs, {duration}, report: a"),
        ("1.03e+04 points a second", "{rate} points a second"),
        ("at 2026-11-28T12:16:09+00:00 until 2026-12-01", "at {time} until {day}"),
        ('File "/clone/a.py", line 12, in step', "File {line}, in step"),
        (f"signed by SHA256:{'b+/C' * 10}abc", "signed by SHA256:{key}"),
        (
            '<th scope="row">seconds</th><td><code>42.8</code>',
            '<th scope="row">seconds</th><td><code>{seconds}</code>',
        ),
        ("0.131 µs a step (native), 0.131 % of the control period", "{time of a step} of the control period"),
        ("| TIM-1 | pass | +0.97 | met | ", "| TIM-1 | pass | {number} | met | "),
        (
            '<th scope="col">time of a step (µs)</th><td>0.23</td></table>0.5',
            '<th scope="col">time of a step (µs)</th><td>{number}</td></table>0.5',
        ),
        ("candidate,step_us,bytes\nfoc,0.23,1048\n", "candidate,step_us,bytes\nfoc,{number},1048\n"),
        ("| DTM-1 | pass | +0.97 | met | ", None),
        ("torque 0.1234567890123456 N·m after 2 s, 1234567890123456 steps", None),
        ("stalled for 12 s, and 1.5 min of 3 min", None),
    ],
)
def test_only_what_has_to_vary_is_replaced(text, shown):
    assert normal(text, PLACES) == (text if shown is None else shown)


def test_texts_and_the_order_of_keys_count_with_the_wording():
    document = {
        "verdict": "fails at 5 rpm",
        "drive": {"name": "mine", "hash": HASH, "provenance": {"phases": "sheet 3"}},
        "candidate": {"hash": HASH},
        "provenance": {"drivegate": "0.1.0"},
        "timing": {"seconds": 1.5, "checks": []},
    }
    assert json.dumps(stripped(document, PLACES)) == json.dumps(
        {
            "verdict": "fails at 5 rpm",
            "drive": {"name": "mine", "hash": HASH, "provenance": {"phases": "sheet 3"}},
            "candidate": {"hash": "{hash}"},
            "provenance": {"drivegate": None},
            "timing": {"seconds": None, "checks": []},
        }
    )
    assert json.dumps(stripped(document, None)) == json.dumps(
        {"candidate": {}, "drive": {"hash": HASH, "name": "mine"}, "verdict": ""}
    )


def test_a_page_is_compared_in_its_words_and_its_figures(tmp_path):
    page = '<p title="why">One  <b>word</b></p><svg><text>in a figure</text></svg><script>let a</script><p>end</p>'
    assert words_of(page) == "why\nOne\nword\nend"
    (tmp_path / "report.html").write_text(page, encoding="utf-8")
    parts = parts_of(tmp_path / "report.html", PLACES)
    assert parts == {"": page, " words": words_of(page), " figures": "<svg><text>in a figure</text></svg>"}


def test_every_faulty_controller_has_a_row_on_a_drive_that_shows_it():
    table = tomllib.loads(
        Path(proof_rows.__file__).with_name("proof_faults.toml").read_text(encoding="utf-8")
    )
    listed = {contract: [] for contract in FAULTS_OF}
    for words, names_of in table.items():
        name, *changes = words.split(" --set ")
        drive = load_drive(name).with_overrides(changes)
        for check, names in names_of.items():
            faults = chosen_faults(names, drive)
            assert {fault.check for fault in faults} == {check}, words
            assert [fault.name for fault in faults if fault.on(drive).idle_because] == [], words
            listed[drive.contract] += names
    assert {contract: sorted(names) for contract, names in listed.items()} == {
        contract: sorted(faults) for contract, faults in FAULTS_OF.items()
    }


def test_names_of_rows_are_their_own():
    names = [row.name for row in proof_rows.rows()]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("name", ["refused manifest key", "new drive"])
def test_the_same_code_has_the_same_lines(tmp_path, name):
    row = next(row for row in proof_rows.rows() if row.name == name)
    lists = []
    for again in ("first", "second"):
        scratch, keep = tmp_path / again, tmp_path / f"kept-{again}"
        scratch.mkdir()
        keep.mkdir()
        lists.append(Listing(scratch, keep, Places.of(scratch)).lines(row))
        kept = "".join(path.read_text(encoding="utf-8") for path in keep.iterdir())
        assert ("the nearest known key is 'estimates_power'" if "refused" in name else "[machine]") in kept
    assert lists[0] == lists[1]
