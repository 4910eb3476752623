"""What can be read from a shared library without loading it, which would run its code."""

import platform
import struct
import sys
from pathlib import Path
from typing import Final

from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

# The beginning of an ELF file: magic, class, byte order, then type and machine (System V ABI, "ELF Header").
_MAGIC: Final = b"\x7fELF"
_HEADER: Final = struct.Struct("<16sHH")
_SHARED: Final = 3
_MACHINES: Final = {
    3: "i686",
    20: "ppc",
    21: "ppc64le",
    22: "s390x",
    40: "arm",
    62: "x86_64",
    183: "aarch64",
    243: "riscv64",
    258: "loongarch64",
}
_OTHER_NAMES: Final = {"amd64": "x86_64", "arm64": "aarch64", "ppc64": "ppc64le"}


def check_shared_library(file: Path) -> None:
    """Refuse a file that is no shared library for this machine."""
    if not sys.platform.startswith("linux"):
        return
    try:
        with file.open("rb") as stream:
            header = stream.read(_HEADER.size)
    except OSError as error:
        raise InputError(
            f"{shown_path(file)} cannot be read: {error.strerror}; name a readable file"
        ) from error
    problem = _problem(header)
    if problem:
        raise InputError(f"{shown_path(file)} {problem}; compile it on this machine with cc -shared -fPIC")


def _problem(header: bytes) -> str:
    if len(header) < _HEADER.size or not header.startswith(_MAGIC):
        return "is no shared library"
    identification, kind, machine = _HEADER.unpack(header)
    word_size, order = identification[4], identification[5]
    here = platform.machine().lower()
    here = _OTHER_NAMES.get(here, here)
    there = _MACHINES.get(machine, f"machine {machine}")
    if word_size != 2 or order != 1:
        bits, end = ("32-bit" if word_size == 1 else "64-bit"), ("little" if order == 1 else "big")
        return f"is {bits} and {end}-endian, but this machine is {here}"
    if there != here:
        return f"is compiled for {there}, but this machine is {here}"
    return "" if kind == _SHARED else "is compiled code, but no shared library"
