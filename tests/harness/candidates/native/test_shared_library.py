"""A file that is no shared library for this machine is refused before anything is loaded."""

import subprocess

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate_models.errors import InputError

MACHINE, KIND, CLASS, ORDER = 18, 16, 4, 5


@pytest.fixture
def library(tmp_path):
    """An empty shared library."""
    source, target = tmp_path / "mine.c", tmp_path / "mine.so"
    source.write_text("int nothing;\n", encoding="utf-8")
    subprocess.run(["cc", "-shared", "-fPIC", str(source), "-o", str(target)], check=True)
    return target


def with_byte(library, place, value):
    content = bytearray(library.read_bytes())
    content[place : place + 1] = bytes([value])
    library.write_bytes(content)


@pytest.mark.parametrize(
    ("place", "value", "reason"),
    [
        (MACHINE, 8, "is compiled for machine 8, but this machine is"),
        (MACHINE, 22, "is compiled for s390x, but this machine is"),
        (CLASS, 1, "is 32-bit and little-endian, but this machine is"),
        (ORDER, 2, "is 64-bit and big-endian, but this machine is"),
        (KIND, 1, "is compiled code, but no shared library"),
        (0, 0, "is no shared library"),
    ],
)
def test_another_machine_is_named(library, place, value, reason):
    with_byte(library, place, value)
    with pytest.raises(InputError, match=reason) as caught:
        resolve_candidate(str(library))
    other = (
        "a process of 64 bits loads no library of 32"
        if place == CLASS
        else "compile it on this machine with cc"
    )
    assert other in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"\x7fELF", b"#!/bin/sh\n", b"\0" * 4096])
def test_garbage_is_no_library(library, content):
    library.write_bytes(content)
    with pytest.raises(InputError, match="is no shared library"):
        resolve_candidate(str(library))


def test_a_library_of_this_machine_is_accepted(library):
    assert resolve_candidate(str(library)).kind == "so"
