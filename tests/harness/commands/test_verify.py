"""``drivegate verify``, and ``--sign`` of the commands that write results, as people and CI servers use them."""

from __future__ import annotations

import copy
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat, PublicFormat

from drivegate.results.result import content_hash
from drivegate.results.signature import fingerprint, public_key_line

Document = dict[str, Any]
KEY = Ed25519PrivateKey.from_private_bytes(bytes(range(32)))
OTHER = Ed25519PrivateKey.from_private_bytes(bytes(32))


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    """Write two keys, private and public."""
    folder = tmp_path / "keys"
    folder.mkdir()
    for name, key in (("mine", KEY), ("other", OTHER)):
        private = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
        public = key.public_key().public_bytes(Encoding.PEM, PublicFormat.SubjectPublicKeyInfo)
        (folder / f"{name}.pem").write_bytes(private)
        (folder / f"{name}.public.pem").write_bytes(public)
        (folder / f"{name}.pub").write_text(
            f"{public_key_line(key.public_key())} me@here\n", encoding="ascii"
        )
    return folder


@pytest.fixture
def unsigned(command: Any, failing: Any, tmp_path: Path) -> Path:
    """Write the result of a candidate that fails in every way, without a signature."""
    ended = command("check", "published", "--output", tmp_path / "unsigned")
    assert ended.code == 1, ended.err
    return tmp_path / "unsigned" / "result.json"


@pytest.fixture
def signed(command: Any, failing: Any, keys: Path, tmp_path: Path) -> Path:
    """Write the same result, signed."""
    ended = command("check", "published", "--sign", keys / "mine.pem", "--output", tmp_path / "signed")
    assert ended.code == 1, ended.err
    assert f"signed by the key {fingerprint(public_key_line(KEY.public_key()))}" in ended.out
    return tmp_path / "signed" / "result.json"


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


def test_a_signed_result_is_valid(command: Any, signed: Path) -> None:
    ended = command("verify", signed)
    assert ended.code == 0, ended.err
    assert "published: exception" in ended.out, "a verdict that fails is still the verdict that was signed"
    assert "valid: unchanged, and signed by the key SHA256:" in ended.out
    assert "--key checks whether that is the one you expect" in ended.out


@pytest.mark.parametrize("public", ["mine.public.pem", "mine.pub"])
def test_the_expected_key(command: Any, signed: Path, keys: Path, public: str) -> None:
    ended = command("verify", signed, "--key", keys / public, "--json")
    name = fingerprint(public_key_line(KEY.public_key()))
    assert ended.code == 0, ended.err
    assert ended.document == {
        "schema": 1,
        "kind": "verification",
        "file": str(signed),
        "outcome": "valid",
        "message": f"unchanged, and signed by the expected key {name}",
        "unchanged": True,
        "signed_by": name,
        "expected_signer": name,
        "content_hash": read(signed)["provenance"]["content_hash"],
        "stated_hash": read(signed)["provenance"]["content_hash"],
        "candidate": "published",
        "verdict": "exception",
        "exit_code": 0,
    }


def test_another_key_than_the_expected(command: Any, signed: Path, keys: Path) -> None:
    ended = command("verify", signed, "--key", keys / "other.pub")
    assert ended.code == 1
    assert (
        f"another key: the signature is valid, but by the key {fingerprint(public_key_line(KEY.public_key()))}"
        in (ended.out)
    )
    document = command("verify", signed, "--key", keys / "other.pub", "--json").document
    assert (document["outcome"], document["exit_code"]) == ("another key", 1)
    assert document["expected_signer"] == fingerprint(public_key_line(OTHER.public_key()))


def test_without_a_signature_the_hash_is_all_there_is(command: Any, unsigned: Path, keys: Path) -> None:
    ended = command("verify", unsigned)
    assert ended.code == 0, ended.err
    assert "there is no signature, and anyone can make a hash" in ended.out
    ended = command("verify", unsigned, "--key", keys / "mine.pub")
    assert ended.code == 1
    assert "not signed: the content fits its hash, but nobody signed it" in ended.out


def test_the_signature_changes_nothing_else(unsigned: Path, signed: Path) -> None:
    plain, made = read(unsigned), read(signed)
    assert set(made) - set(plain) == {"signature"}
    assert made["provenance"] == plain["provenance"], "the content hash must not depend on who signs"


@pytest.mark.parametrize("name", ["unsigned", "signed"])
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
        made = verification(write(file, altered(document, place)), None)
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
def test_no_byte_of_the_content_can_be_another(command: Any, signed: Path, old: bytes, new: bytes) -> None:
    data = signed.read_bytes()
    assert old in data
    signed.write_bytes(data.replace(old, new, 1))
    ended = command("verify", signed)
    assert ended.code == 1, "an altered result must not be verified"
    assert "altered: the result was altered: its content is not that of its content hash" in ended.out
    assert "publishe" not in ended.out, "what an altered result says is not worth repeating"


@pytest.mark.parametrize("change", [{"surplus": 1}, {"verdict": None}, {"traces": [{"time_s": [1e400]}]}])
def test_no_key_can_be_added_or_emptied(command: Any, signed: Path, change: Document) -> None:
    file = signed.with_name("changed.json")
    file.write_text(json.dumps({**read(signed), **change}).replace("Infinity", "1e400"), encoding="utf-8")
    assert command("verify", file).code == 1


def test_a_new_hash_does_not_help(command: Any, signed: Path, keys: Path) -> None:
    document = read(signed)
    document["verdict"], document["exit_code"] = "pass", 0
    document["provenance"]["content_hash"] = content_hash(document)
    ended = command("verify", write(signed, document))
    assert ended.code == 1
    assert "invalid signature: the content fits its hash, but" in ended.out
    # Whoever takes the signature off or makes another is found by the key that is expected.
    other = command("report", signed, "--sign", keys / "other.pem", "--output", "other")
    assert other.code == 0, other.err
    assert command("verify", "other/result.json").code == 0
    assert command("verify", "other/result.json", "--key", keys / "mine.pub").code == 1
    write(signed, {key: value for key, value in document.items() if key != "signature"})
    assert command("verify", signed).code == 0
    assert command("verify", signed, "--key", keys / "mine.pub").code == 1


@pytest.mark.parametrize("part", ["public_key", "value"])
def test_no_byte_of_the_signature_can_be_another(command: Any, signed: Path, part: str) -> None:
    document = read(signed)
    text = document["signature"][part]
    document["signature"][part] = text[:40] + ("A" if text[40] != "A" else "B") + text[41:]
    ended = command("verify", write(signed, document))
    assert ended.code == 1
    assert "invalid signature" in ended.out


def test_times_are_not_covered(command: Any, signed: Path, keys: Path) -> None:
    document = read(signed)
    document["timing"]["seconds"] += 1
    assert command("verify", write(signed, document), "--key", keys / "mine.pub").code == 0


def test_form_and_order_are_not_the_content(command: Any, signed: Path, keys: Path) -> None:
    document = dict(reversed(read(signed).items()))
    assert command("verify", write(signed, document), "--key", keys / "mine.pub").code == 0


def test_a_kept_result_is_signed_later(command: Any, unsigned: Path, signed: Path, keys: Path) -> None:
    ended = command("report", unsigned, "--sign", keys / "mine.pem", "--output", "later")
    assert ended.code == 0, ended.err
    assert Path("later/result.json").read_bytes() == signed.read_bytes(), (
        "who signs, and what, gives the bytes"
    )
    again = command("report", "later/result.json", "--output", "again")
    assert again.code == 0, again.err
    assert Path("again/result.json").read_bytes() == signed.read_bytes(), "a report keeps the signature"


def test_an_altered_result_is_not_signed(refused: Any, unsigned: Path, keys: Path) -> None:
    write(unsigned, {**read(unsigned), "seed": 1})
    assert "altered after it was made" in refused("report", unsigned, "--sign", keys / "mine.pem")


@pytest.mark.usefixtures("engine")
def test_each_of_several_results_is_signed(command: Any, refused: Any, keys: Path, tmp_path: Path) -> None:
    ended = command("check", "reference", "published", "--sign", keys / "mine.pem", "--output", "both")
    assert ended.code == 0, ended.err
    for name in ("reference", "published"):
        assert command("verify", f"both/{name}/result.json", "--key", keys / "mine.pub").code == 0
    assert "holds the results of several candidates" in refused("verify", "both/result.json")


def test_a_key_that_is_none_is_refused_before_anything_runs(refused: Any, engine: Any, keys: Path) -> None:
    said = refused("check", "reference", "--sign", keys / "mine.pub")
    assert "holds a public key, but a result is signed with the private one" in said
    assert "does not exist" in refused("check", "reference", "--sign", keys / "missing.pem")
    assert engine.options is None, "the check had begun"


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
    assert "neither a TOML nor a JSON file by its name" in refused("verify", tmp_path)


def test_a_hash_over_nonsense_makes_no_result(refused: Any, tmp_path: Path) -> None:
    document: Document = {"schema": 2, "kind": "check", "faults": [], "provenance": {}}
    document["provenance"]["content_hash"] = content_hash(document)
    assert "the key 'candidate' is missing" in refused("verify", write(tmp_path / "result.json", document))


@pytest.mark.parametrize("depth", [100, 400, 900, 5000])
def test_a_deep_document_ends_in_one_sentence(command: Any, signed: Path, depth: int) -> None:
    document = read(signed)
    text = json.dumps({**document, "deep": "HERE"}).replace('"HERE"', "[" * depth + "]" * depth)
    signed.write_text(text, encoding="utf-8")
    ended = command("verify", signed)
    assert ended.code in (1, 2), ended.err
    assert len((ended.out + ended.err).splitlines()) == 1


def test_a_missing_package_is_named(
    refused: Any, signed: Path, unsigned: Path, keys: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "cryptography.hazmat.primitives.asymmetric.ed25519", None)
    needed: list[tuple[object, ...]] = [
        ("verify", signed),
        ("verify", unsigned, "--key", keys / "mine.pub"),
        ("report", unsigned, "--sign", keys / "mine.pem", "--output", "new"),
        ("check", "reference", "--sign", keys / "mine.pem", "--output", "new"),
    ]
    for words in needed:
        assert "pip install cryptography" in refused(*words)


def test_the_package_is_imported_only_where_it_is_needed(unsigned: Path) -> None:
    program = (
        "import sys\nfrom drivegate.commands.command_line import main\n"
        f"try: main(['verify', {str(unsigned)!r}])\nexcept SystemExit as ended: print('LOADED', ended.code, "
        "*sorted(name for name in sys.modules if name.startswith('cryptography')))"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ended.stdout.splitlines()[-1] == "LOADED 0", "an unsigned result needs no package for signatures"


def test_no_private_key_is_repeated(signed: Path, keys: Path) -> None:
    secret = re.sub(r"-----.*-----|\s", "", (keys / "mine.pem").read_text(encoding="ascii"))
    for file in signed.parent.rglob("*"):
        if file.is_file():
            assert secret not in file.read_text(encoding="utf-8"), f"{file.name} holds the key"
            assert KEY.private_bytes_raw().hex() not in file.read_text(encoding="utf-8")
