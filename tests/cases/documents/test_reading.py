import json
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivegate_cases.documents.reading import (
    DEEPEST,
    LARGEST_FILE_BYTES,
    LARGEST_TOML_BYTES,
    MOST_ENTRIES,
    MOST_KEYS,
    read_mapping,
)
from drivegate_models.errors import InputError


def written(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def test_toml_and_json_say_the_same(tmp_path: Path) -> None:
    toml = written(tmp_path, "a.toml", "number = 1.5\nlist = [[0, 1]]\n[table]\ntext = 'N·m'\n")
    as_json = written(tmp_path, "a.JSON", '{"number": 1.5, "list": [[0, 1]], "table": {"text": "N·m"}}')
    assert read_mapping(toml) == read_mapping(str(as_json))


def test_a_byte_order_mark_is_no_error(tmp_path: Path) -> None:
    assert read_mapping(written(tmp_path, "a.toml", b"\xef\xbb\xbfa = 1")) == {"a": 1}


@pytest.mark.parametrize(
    ("name", "content", "reported"),
    [
        ("a.toml", "a = 1\nb = \n", "not well-formed TOML"),
        ("a.toml", "a = 1\nb = \n", "line 2"),
        ("a.toml", 'a = 1\nb = "mine\nc = 2\n', "in line 2 a string is not closed"),
        ("a.toml", "a = 1\nb = 'mine\nc = 2\n", "a string is not closed up to the end"),
        ("a.toml", 'a = """mine\nc = 2\n', "a string is not closed up to the end of the file"),
        ("a.toml", "a = 1\na = 2\n", "not well-formed TOML"),
        ("a.toml", "a = 2020-13-45\n", "not well-formed TOML"),
        (
            "a.toml",
            "a = 1\nb = 0,5\n",
            "in line 2 the number 0,5 has a decimal comma; write it with a point, 0.5",
        ),
        ("a.toml", "[m]\r\nb = -1.200,5e-3  # in ohm\r\n", "write it with a point, -1200.5e-3"),
        ("a.toml", "m = { b = 0,5 }", "write it with a point, 0.5"),
        ("a.json", '{"a": 0,5,\n"b": 2}', "the number 0,5 has a decimal comma; write it with a point, 0.5"),
        ("a.json", '{"a": 1,\n"b" 2}', "line 2, column 5"),
        ("a.json", "", "not well-formed JSON at line 1"),
        ("a.json", '{"a": 1, "b": 2, "a": 3}', 'the key "a" appears more than once'),
        ("a.json", '{"a": NaN}', "must be finite"),
        ("a.json", '{"a": -Infinity}', "must be finite"),
        ("a.json", "[1, 2]", "must hold a table"),
        ("a.json", "null", "must hold a table"),
        ("a.json", "[" * 200_000, "nested too deeply"),
        ("a.toml", "a = " + "[" * 100_000, "nested too deeply"),
        ("a.json", '{"a": 1' + "0" * 5000 + "}", "not well-formed JSON"),
        ("a.toml", "a = 1" + "0" * 5000, "not well-formed TOML"),
        ("a.toml", b"a = 1\nb = '\xff\xfe'", "not text in UTF-8 (byte 11, line 2)"),
        ("a.json", bytes(range(256)), "not text in UTF-8"),
        ("a.yaml", "a: 1", "must end in .toml or .json"),
        ("a", "a = 1", "must end in .toml or .json"),
    ],
)
def test_what_is_no_document_is_reported(
    tmp_path: Path, refusal: Callable[..., str], name: str, content: str | bytes, reported: str
) -> None:
    message = refusal(read_mapping, written(tmp_path, name, content))
    assert reported in message
    assert name in message


def test_a_repeated_key_among_very_many_is_found_at_once(tmp_path: Path, refusal: Callable[..., str]) -> None:
    keys = ", ".join(f'"k{number}": 1' for number in [*range(100_000), 99_999])
    began = time.process_time()
    assert 'the key "k99999"' in refusal(read_mapping, written(tmp_path, "a.json", f"{{{keys}}}"))
    assert time.process_time() - began < 5.0, "the time grows with the square of the number of keys"


def test_a_missing_file_is_named(tmp_path: Path, refusal: Callable[..., str]) -> None:
    message = refusal(read_mapping, tmp_path / "no such.toml")
    assert "no such.toml does not exist" in message


def test_a_folder_is_no_document(tmp_path: Path, refusal: Callable[..., str]) -> None:
    (tmp_path / "folder.toml").mkdir()
    assert "is a folder" in refusal(read_mapping, tmp_path / "folder.toml")


def test_a_pipe_is_not_waited_for(tmp_path: Path, refusal: Callable[..., str]) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    assert "not a regular file" in refusal(read_mapping, tmp_path / "pipe.toml")


@pytest.mark.parametrize(
    "path", ["nul\0l.toml", "x" * 5000 + ".toml", "a.toml/b.toml", "line\nbreak.toml", ""]
)
def test_an_impossible_path_is_refused(
    tmp_path: Path, refusal: Callable[..., str], monkeypatch: pytest.MonkeyPatch, path: str
) -> None:
    monkeypatch.chdir(tmp_path)
    written(tmp_path, "a.toml", "a = 1")
    refusal(read_mapping, path)


@pytest.mark.parametrize(
    ("name", "most", "size"),
    [("huge.json", LARGEST_FILE_BYTES, "16 MB"), ("huge.toml", LARGEST_TOML_BYTES, "4 MB")],
)
def test_a_huge_file_is_refused_at_its_size(
    tmp_path: Path, refusal: Callable[..., str], name: str, most: int, size: str
) -> None:
    path = tmp_path / name
    with path.open("wb") as stream:
        stream.truncate(most + 1)
    assert f"larger than {size}" in refusal(read_mapping, path)


@pytest.mark.parametrize(
    ("name", "content", "reported"),
    [
        ("a.json", '{"a": ' * DEEPEST + "1" + "}" * DEEPEST, None),
        ("a.json", '{"a": ' * DEEPEST + "[]" + "}" * DEEPEST, "nested too deeply"),
        ("a.json", '{"a": ' * 900 + "1" + "}" * 900, "nested too deeply"),
        ("a.toml", "a = " + "[" * DEEPEST + "]" * DEEPEST, "nested too deeply"),
        ("a.toml", "a." * (DEEPEST - 1) + "a = 1", None),
        ("a.toml", "a." * DEEPEST + "a = 1", "nested too deeply"),
        ("a.toml", "a." * 1_000_000 + "a = 1", "nested too deeply"),
        ("a.toml", "[" + "'a' . " * 500_000 + "a]", "nested too deeply"),
        ("a.toml", "a = '" + "word, another word. " * 1000 + "'", None),
        ("a.json", json.dumps(dict.fromkeys(map(str, range(MOST_KEYS)))), None),
        ("a.json", json.dumps({"a": dict.fromkeys(map(str, range(MOST_KEYS)))}), "more than 200000 keys"),
        ("a.json", json.dumps({"a": [0] * (MOST_ENTRIES + 1)}), "more than 1000000 entries"),
    ],
    ids=lambda value: value[:20] if isinstance(value, str) else "",
)
def test_a_document_of_too_great_an_extent_is_refused(
    tmp_path: Path, refusal: Callable[..., str], name: str, content: str, reported: str | None
) -> None:
    path = written(tmp_path, name, content)
    if reported is None:
        assert read_mapping(path)
    else:
        assert reported in refusal(read_mapping, path)


@given(st.binary(max_size=200), st.sampled_from([".toml", ".json"]))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_bytes_give_a_table_or_a_sentence(tmp_path: Path, content: bytes, suffix: str) -> None:
    path = written(tmp_path, f"a{suffix}", content)
    reported = path.name
    try:
        assert isinstance(read_mapping(path), dict)
    except InputError as error:
        reported = str(error)
    assert reported.isprintable(), f"the message does not fit on one line: {reported!r}"
    assert path.name in reported, f"the message does not name the file: {reported}"


PLAIN_TABLES = st.dictionaries(
    st.text(max_size=8),
    st.recursive(
        st.booleans()
        | st.integers()
        | st.floats(allow_nan=False, allow_infinity=False)
        | st.text(max_size=8),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
        max_leaves=10,
    ),
    max_size=5,
)


@given(PLAIN_TABLES)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_what_json_writes_is_read_back(tmp_path: Path, table: dict[str, Any]) -> None:
    assert read_mapping(written(tmp_path, "a.json", json.dumps(table))) == table
