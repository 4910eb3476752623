"""``drivegate verify``, as people and CI servers use it."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from drivegate.results.result import content_hash

Document = dict[str, Any]
SIGNATURE = {
    "public_key": "ssh-ed25519 AAAAC3NzaC1lZDI1NTE5AAAAIAOhB7/zzhC+HXDdGOdLwJln5NYwm6UNXx3chmQSVTG4",
    "value": "00",
}


@pytest.fixture
def kept(command: Any, failing: Any, tmp_path: Path) -> Path:
    """Write the result of a candidate that fails in every way."""
    ended = command("check", "published", "--output", tmp_path / "kept")
    assert ended.code == 1, ended.err
    return tmp_path / "kept" / "result.json"


@pytest.fixture
def signed(kept: Path) -> Path:
    """Write the same result with the signature that an earlier version wrote into it."""
    return write(kept.with_name("signed.json"), {**read(kept), "signature": SIGNATURE})


def read(path: Path) -> Document:
    return json.loads(path.read_text(encoding="utf-8"))


def write(path: Path, document: Document) -> Path:
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def places(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """List the places of all values that are no tables and lists, and of empty ones."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    inside = [place for key, item in items for place in places(item, (*at, key))]
    yield from inside or [at]


def altered(document: Document, place: tuple[Any, ...]) -> Document:
    """Alter one value as little as its type allows."""
    changed = copy.deepcopy(document)
    holder: Any = changed
    for key in place[:-1]:
        holder = holder[key]
    value = holder[place[-1]]
    if isinstance(value, bool) or value is None:
        other: Any = not value
    elif isinstance(value, str):
        other = value[:-1] + chr(ord(value[-1]) ^ 1) if value else " "
    elif isinstance(value, int | float):
        other = value + 1
    else:
        other = [0] if isinstance(value, list) else {"": 0}
    holder[place[-1]] = other
    return changed


def test_an_unchanged_result(command: Any, kept: Path) -> None:
    ended = command("verify", kept, "--json")
    assert ended.code == 0, ended.err
    assert ended.document == {
        "schema": 2,
        "kind": "verification",
        "file": str(kept),
        "outcome": "unchanged",
        "message": "the content fits its hash, but anyone can make a hash; a signature of the file shows whose it is",
        "unchanged": True,
        "content_hash": read(kept)["provenance"]["content_hash"],
        "stated_hash": read(kept)["provenance"]["content_hash"],
        "candidate": "published",
        "verdict": "exception",
        "exit_code": 0,
    }
    ended = command("verify", kept)
    assert "published: exception" in ended.out, "a verdict that fails is still the verdict that was kept"
    assert "unchanged: the content fits its hash, but anyone can make a hash" in ended.out


def test_a_signature_of_an_earlier_version_is_said_not_to_be_checked(command: Any, signed: Path) -> None:
    ended = command("verify", signed)
    assert ended.code == 0, ended.err
    assert "no longer checks the signature in the result" in ended.out
    assert "check it with ssh-keygen -Y verify" in " ".join(ended.out.split())
    again = command("report", signed, "--output", "again")
    assert again.code == 0, again.err
    assert read(Path("again/result.json")) == read(signed), "a report keeps what it does not check"


def test_an_option_that_asks_for_a_signature_is_refused(refused: Any, kept: Path) -> None:
    for option, words in (("--key", ("verify", kept)), ("--sign", ("check", "reference"))):
        said = refused(*words, option, "key.pem")
        assert "No such option" in said
        assert option in said


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["kept", "signed"])
def test_no_value_can_be_altered(
    command: Any, request: pytest.FixtureRequest, name: str, tmp_path: Path
) -> None:
    document = read(request.getfixturevalue(name))
    uncovered = {("timing",), ("faults", 0, "traceback"), ("faults", 1, "traceback"), ("signature",)}
    covered = [
        place for place in places(document) if not any(place[: len(part)] == part for part in uncovered)
    ]
    # Of another kind there is nothing to verify.
    covered.remove(("kind",))
    assert len(covered) > 150, "there must be something to alter"
    from drivegate.studies.verify import verification

    file = tmp_path / "altered.json"
    for place in covered:
        made = verification(write(file, altered(document, place)))
        assert (made["outcome"], made["exit_code"]) == ("altered", 1), f"{place} can be altered"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b'"verdict": "exception"', b'"verdict": "exceptioo"'),
        (b'"exit_code": 1', b'"exit_code": 0'),
        (b'"margin": -1.5', b'"margin": -0.5'),
        (b'"seed": 0', b'"seed": 1'),
        (b'"name": "published"', b'"name": "publishee"'),
        (b'"drivegate": "0.1.0"', b'"drivegate": "0.1.1"'),
        (b'"step": 3', b'"step": 4'),
        (b'"requirement": "The requirement."', b'"requirement": "The requirement!"'),
    ],
)
def test_no_byte_of_the_content_can_be_another(command: Any, kept: Path, old: bytes, new: bytes) -> None:
    data = kept.read_bytes()
    assert old in data
    kept.write_bytes(data.replace(old, new, 1))
    ended = command("verify", kept)
    assert ended.code == 1, "an altered result must not be verified"
    assert "altered: the result was altered: its content is not that of its content hash" in ended.out
    assert "publishe" not in ended.out, "what an altered result says is not worth repeating"


@pytest.mark.parametrize("change", [{"surplus": 1}, {"verdict": None}, {"traces": [{"time_s": [1e400]}]}])
def test_no_key_can_be_added_or_emptied(command: Any, kept: Path, change: Document) -> None:
    file = kept.with_name("changed.json")
    file.write_text(json.dumps({**read(kept), **change}).replace("Infinity", "1e400"), encoding="utf-8")
    assert command("verify", file).code == 1


def test_times_are_not_covered(command: Any, kept: Path) -> None:
    document = read(kept)
    document["timing"]["seconds"] += 1
    assert command("verify", write(kept, document)).code == 0


def test_form_and_order_are_not_the_content(command: Any, kept: Path) -> None:
    document = dict(reversed(read(kept).items()))
    assert command("verify", write(kept, document)).code == 0


@pytest.mark.usefixtures("engine")
def test_each_of_several_results_is_verified_alone(command: Any, refused: Any) -> None:
    ended = command("check", "reference", "published", "--output", "both")
    assert ended.code == 0, ended.err
    for name in ("reference", "published"):
        assert command("verify", f"both/{name}/result.json").code == 0
    assert "holds the results of several candidates" in refused("verify", "both/result.json")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is not well-formed JSON"),
        ("[]", "must hold a table"),
        ("{", "is not well-formed JSON"),
        ("{}", "does not give its kind"),
        ('{"kind": "counterexample"}', "is of kind"),
        ('{"kind": "check"}', "has no content hash"),
        ('{"kind": "check", "provenance": []}', "has no content hash"),
        ('{"kind": "check", "provenance": {"content_hash": 3}}', "has no content hash"),
        ('{"kind": "check", "provenance": {"content_hash": "x"}}', "has no list of tables 'faults'"),
        (
            '{"kind": "check", "provenance": {"content_hash": "x"}, "faults": [3]}',
            "no list of tables 'faults'",
        ),
        ('{"kind": "check", "kind": "check"}', "more than once"),
        ('{"kind": "check", "seed": NaN}', "NaN is no JSON number"),
        ("\0" * 10_000_000, "is not well-formed JSON"),
        ('{"kind": "check", "verdict": "' + "x" * 10_000_000 + '"}', "has no content hash"),
        ("[" * 100_000, "nested too deeply"),
        (" " * (16 * 1024**2 + 1), "is larger than 16 MB"),
    ],
)
def test_a_file_that_is_no_result(refused: Any, tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "result.json"
    file.write_text(text, encoding="utf-8")
    assert said in refused("verify", file)


def test_a_file_that_cannot_be_one(refused: Any, tmp_path: Path) -> None:
    assert "does not exist" in refused("verify", "missing.json")
    assert "is a folder; name a TOML or JSON file in it" in refused("verify", tmp_path)


def test_a_hash_over_nonsense_makes_no_result(refused: Any, tmp_path: Path) -> None:
    document: Document = {"schema": 2, "kind": "check", "faults": [], "provenance": {}}
    document["provenance"]["content_hash"] = content_hash(document)
    assert "the key 'candidate' is missing" in refused("verify", write(tmp_path / "result.json", document))


@pytest.mark.parametrize("depth", [100, 400, 900, 5000])
def test_a_deep_document_ends_in_one_sentence(command: Any, kept: Path, depth: int) -> None:
    document = read(kept)
    text = json.dumps({**document, "deep": "HERE"}).replace('"HERE"', "[" * depth + "]" * depth)
    kept.write_text(text, encoding="utf-8")
    ended = command("verify", kept)
    assert ended.code in (1, 2), ended.err
    assert len((ended.out + ended.err).splitlines()) == 1
