"""What an ELF image consists of: segments of memory, functions, and the lines of its sources."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

from elftools.common.exceptions import DWARFError, ELFError
from elftools.elf.elffile import ELFFile

from drivegate.candidates.elf.memory import ADDRESSES, Stretch
from drivegate_cases.documents.wording import short_line, shown_path
from drivegate_models.errors import InputError

LARGEST_IMAGE: Final = 64 * 2**20
"""Greatest size of all segments of an image in memory (bytes)."""

# Values of Tag_CPU_arch and Tag_FP_arch (Addenda to the ABI for the Arm architecture, "Build attributes").
_CORES: Final = {
    10: "CORTEX_M3",
    11: "CORTEX_M0",
    12: "CORTEX_M0",
    13: "CORTEX_M4",
    16: "CORTEX_M33",
    17: "CORTEX_M33",
}
_WITH_DOUBLES: Final = (7, 8)
_ARMV8_1_M: Final = 21


@dataclass(frozen=True)
class Segment:
    address: int
    """Where the code expects it."""
    content: bytes
    """What is in it after loading; zeros follow."""
    size: int
    """Number of bytes."""
    is_executable: bool
    flashed_at: int
    """Where a programmer writes its content; start-up code copies it from there, where this is another address."""


@dataclass(frozen=True)
class Image:
    file: Path
    segments: tuple[Segment, ...]
    """Its memory, at the addresses at which the code runs; initial values need not be copied."""
    stretches: tuple[Stretch, ...]
    """What the code may do where; stretches may overlap."""
    functions: Mapping[str, int]
    """Address of each function by its name."""
    sizes: Mapping[str, int]
    """Size of each function by its name (bytes)."""
    core: str
    """Name of the processor core that it is built for, as the emulator has it."""


@cache
def read_image(file: Path) -> Image:
    """Read an image.

    Raises InputError if it is damaged, too large, or for another kind of processor.
    """
    try:
        with file.open("rb") as stream:
            elf = ELFFile(stream)
            functions, sizes = _functions(elf)
            segments = _segments(elf, file)
            image = Image(file, segments, stretches_of(elf, segments), functions, sizes, _core(elf, file))
    except (ELFError, OSError, ValueError, KeyError, IndexError, OverflowError) as error:
        raise InputError(
            f"{shown_path(file)} cannot be read as an ELF image: {short_line(str(error)) or type(error).__name__}; "
            "link it again"
        ) from error
    return image


def linked_name(image: Image, name: str) -> str:
    """Return the name of a function as it is linked: in C++ another one than in the source, unless overloaded."""
    if name in image.functions:
        return name
    found = [each for each in image.functions if source_name(each) == name and not _is_clone(each)]
    return found[0] if len(found) == 1 else name


def clone_of(image: Image, name: str) -> str:
    """Return the name of what the compiler has made of a function that is called in one way only; empty for none."""
    clones = (each for each in image.functions if _is_clone(each))
    return next((each for each in clones if name in (each.partition(".")[0], source_name(each))), "")


def _is_clone(linked: str) -> bool:
    return "." in linked


# Itanium C++ ABI, section 5.1: each part of a name follows its length, and N and E enclose several.
_MANGLED: Final = re.compile(r"_Z(?:N[rVK]*[RO]?|L)?(?=\d)")
_PART: Final = re.compile(r"L?(\d+)")


def source_name(linked: str) -> str:
    """Return the name that a C++ function has in its source, with its namespaces; empty for others."""
    begin, parts = _MANGLED.match(linked), []
    rest = "" if begin is None else linked[begin.end() :]
    while (length := _PART.match(rest)) is not None:
        rest = rest[length.end() :]
        parts.append(rest[: int(length[1])])
        rest = rest[int(length[1]) :]
        if begin is not None and "N" not in begin[0]:
            break
    return "::".join(part for part in parts if not part.startswith("_GLOBAL__N_"))


def place_of(image: Image, address: int) -> str:
    """Name the function and, if the image has it, the line of the source at an address."""
    name = next(
        (name for name, start in image.functions.items() if start <= address < start + image.sizes[name]), ""
    )
    line = _line_of(image.file, address)
    within = f"in {short_line(name)}" if name else "outside of all functions"
    return f"{within}{f' ({short_line(line)})' if line else ''}, at {hexadecimal(address)}"


def halfwords_of(first: int) -> int:
    """Return how many halfwords an instruction has that begins with one.

    One of 32 bits begins with 11101, 11110 or 11111 (Armv7-M Architecture Reference Manual, A5.1).
    """
    return 2 if first >> 11 >= 0b11101 else 1


def hexadecimal(address: int) -> str:
    """Write an address of the target; unlike one of this machine it is the same in each run, and stays in reports."""
    return f"{address:08X}h"


def _loaded(elf: Any) -> list[Any]:
    return [each for each in elf.iter_segments() if each["p_type"] == "PT_LOAD" and each["p_memsz"]]


def _segments(elf: Any, file: Path) -> tuple[Segment, ...]:
    loaded = _loaded(elf)
    if sum(each["p_memsz"] for each in loaded) > LARGEST_IMAGE:
        raise InputError(
            f"{shown_path(file)} takes more than {LARGEST_IMAGE // 2**20} MiB of memory; an image may take no more"
        )
    beyond = [each for each in loaded if each["p_vaddr"] + each["p_memsz"] > ADDRESSES]
    if beyond:
        raise InputError(
            f"{shown_path(file)} has a segment at {hexadecimal(beyond[0]['p_vaddr'])} that ends beyond the last "
            "address; link it to the memory of its processor"
        )
    # Linkers that state no place in flash leave all of them 0.
    are_flashed = any(each["p_paddr"] for each in loaded)
    return tuple(
        Segment(
            each["p_vaddr"],
            each.data()[: each["p_memsz"]],
            each["p_memsz"],
            bool(each["p_flags"] & 1),
            each["p_paddr"]
            if are_flashed and each["p_paddr"] + each["p_memsz"] <= ADDRESSES
            else each["p_vaddr"],
        )
        for each in loaded
    )


# Tables of functions to call, which only a loader of shared libraries would write.
_CONSTANT_TABLES: Final = ("SHT_INIT_ARRAY", "SHT_FINI_ARRAY", "SHT_PREINIT_ARRAY")
_WRITABLE, _ALLOCATED, _EXECUTABLE = 1, 2, 4


def stretches_of(elf: Any, segments: Sequence[Segment]) -> tuple[Stretch, ...]:
    """List what the code of an image may do where.

    Vendors' linker scripts make a single segment of code, tables and constants, which its flags allow everything. The
    sections within it say more.
    """
    sections = [
        Stretch(
            each["sh_addr"],
            each["sh_size"],
            bool(each["sh_flags"] & _WRITABLE) and each["sh_type"] not in _CONSTANT_TABLES,
            bool(each["sh_flags"] & _EXECUTABLE),
        )
        for each in elf.iter_sections()
        if each["sh_flags"] & _ALLOCATED and each["sh_size"]
    ]
    found: list[Stretch] = []
    for segment, described in zip(segments, _loaded(elf), strict=True):
        within = [
            each
            for each in sections
            if segment.address <= each.address and each.address + each.size <= segment.address + segment.size
        ]
        may_write = bool(described["p_flags"] & 2) and not within
        if segment.flashed_at != segment.address and segment.content:
            # What start-up code copies, code for RAM included, is in writable memory.
            may_write = True
            found.append(Stretch(segment.flashed_at, len(segment.content), False, False))
        found.append(Stretch(segment.address, segment.size, may_write, segment.is_executable and not within))
        found += within
    return tuple(found)


def _functions(elf: Any) -> tuple[dict[str, int], dict[str, int]]:
    table = elf.get_section_by_name(".symtab")
    found = [
        symbol
        for symbol in (() if table is None else table.iter_symbols())
        if symbol["st_info"]["type"] == "STT_FUNC" and symbol["st_shndx"] != "SHN_UNDEF"
    ]
    # The lowest bit of an address marks Thumb code.
    addresses = {symbol.name: symbol["st_value"] & ~1 for symbol in found}
    return addresses, {symbol.name: symbol["st_size"] for symbol in found}


def attributes_of(elf: Any) -> dict[str, Any]:
    """Return what an image states of its processor and its calls (section "Build attributes"), by tag."""
    section = elf.get_section_by_name(".ARM.attributes")
    return {
        found.tag: found.value
        for part in (() if section is None else section.iter_subsections("aeabi"))
        for scope in part.iter_subsubsections(scope="TAG_FILE")
        for found in scope.iter_attributes()
    }


def _core(elf: Any, file: Path) -> str:
    stated = attributes_of(elf)
    if stated.get("TAG_CPU_ARCH") == _ARMV8_1_M:
        raise InputError(
            f"{shown_path(file)} is built for Armv8.1-M, such as a Cortex-M55 or M85, whose instructions the emulator "
            "does not have; build it with -mcpu=cortex-m33"
        )
    core = _CORES.get(stated.get("TAG_CPU_ARCH", 13))
    if core is None or stated.get("TAG_CPU_ARCH_PROFILE", 77) not in (0, 77):
        raise InputError(
            f"{shown_path(file)} is not built for a Cortex-M; build it with -mcpu=cortex-m4, for example"
        )
    return "CORTEX_M7" if core == "CORTEX_M4" and stated.get("TAG_FP_ARCH") in _WITH_DOUBLES else core


def _line_of(file: Path, address: int) -> str:
    """Look a line of a source up; empty where the image has none."""
    try:
        with file.open("rb") as stream:
            elf = ELFFile(stream)
            if not elf.has_dwarf_info():
                return ""
            dwarf = elf.get_dwarf_info()
            for unit in dwarf.iter_CUs():
                found = _line_in(dwarf.line_program_for_CU(unit), address)
                if found:
                    return found
    except (DWARFError, ELFError, KeyError, IndexError, ValueError, OSError):
        return ""
    return ""


def _line_in(program: Any, address: int) -> str:
    before = None
    for entry in () if program is None else program.get_entries():
        state = entry.state
        if state is None:
            continue
        if before is not None and before.address <= address < state.address:
            files = program["file_entry"]
            first = 0 if program["version"] >= 5 else 1
            return f"{files[before.file - first].name.decode(errors='replace')} line {before.line}"
        before = None if state.end_sequence else state
    return ""
