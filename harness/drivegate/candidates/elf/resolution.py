"""From an ELF image or its manifest to a candidate; the image is only hashed here, a worker process reads it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final

from drivegate.candidates.candidate import Candidate, Stub, Target, existing_folder, hash_of
from drivegate.candidates.elf.expression import parsed, parsed_place
from drivegate.candidates.native.resolution import (
    ElfHeader,
    built_or_given,
    contract_served,
    elf_header,
    project_build,
)
from drivegate.candidates.step_costs import StepCosts
from drivegate_cases.documents.reach import existing_file
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.manifest import Manifest, StubTable
    from drivegate_cases.documents.reach import Reach

_CORTEX_M: Final = ElfHeader(word_size=1, byte_order=1, kind=2, machine=40)
"""That of a linked image for Arm."""


def from_text(specification: str) -> Candidate:
    file = existing_file(Path(specification))
    _require_emulator(file)
    return _candidate(specification, file, (file,), Target(file))


def from_manifest(manifest: Manifest, specification: str, reach: Reach) -> Candidate:
    file, further = manifest.files(specification, reach)
    _require_emulator(file)
    build = project_build(manifest, further, specification, reach.folder)
    image, sources = built_or_given(build, file, further)
    target = Target(
        image,
        (manifest.start,) if isinstance(manifest.start, str) else manifest.start,
        manifest.ram,
        StepCosts(manifest.step_instructions or 0, manifest.step_cycles or 0, manifest.stack_bytes or 0),
        manifest.step,
        _table(manifest.peripherals),
        _table(manifest.write),
        _table(manifest.read),
        tuple(_stub(function, stated) for function, stated in manifest.stub.items()),
        _table(manifest.once),
        manifest.pause,
    )
    _check_tables(target, shown_path(specification))
    return _candidate(specification, file, sources, target, manifest.build)


def _table(values: Mapping[str, str | float]) -> tuple[tuple[str, str], ...]:
    return tuple((key, _text(value)) for key, value in values.items())


def _text(value: str | float) -> str:
    return value if isinstance(value, str) else repr(value)


def _stub(function: str, stated: str | float | StubTable) -> Stub:
    if isinstance(stated, str | int | float):
        return Stub(function, _text(stated))
    return Stub(function, _text(stated.returns), _table(stated.fills))


def _check_tables(target: Target, where: str) -> None:
    """Refuse what is no expression, before any process starts; names are looked up where the image is loaded."""
    for key, places, values in (
        ("peripherals", (), target.peripherals),
        ("write", target.write, target.write),
        ("read", (), target.read),
        ("once", target.once, target.once),
        ("stub", (), tuple((stub.function, stub.returns) for stub in target.stub)),
        *(("stub", stub.fills, stub.fills) for stub in target.stub),
    ):
        try:
            for place, _ in places:
                parsed_place(place)
            for _, value in values:
                (parsed_place if key == "peripherals" else parsed)(value)
        except InputError as error:
            raise InputError(f"{where}: in [{key}], {error}") from error


def _candidate(
    specification: str, file: Path, sources: tuple[Path, ...], target: Target, commands: tuple[str, ...] = ()
) -> Candidate:
    _require_cortex_m(target.image)
    # Where the image is says nothing of what it is.
    digest = hash_of(sources, repr((replace(target, image=Path()), commands)))
    return Candidate(
        Path(specification).name,
        "elf",
        specification,
        str(file),
        existing_folder(file),
        sources,
        digest,
        details=target,
        contract=contract_served(target.image),
    )


def _require_emulator(file: Path) -> None:
    if find_spec("unicorn") is None or find_spec("elftools") is None:
        raise InputError(
            f"{shown_path(file)} runs in an emulator that is not installed; install it with "
            "python -m pip install 'drivegate[elf]'"
        )


def _require_cortex_m(file: Path) -> None:
    header = elf_header(file)
    if header is None:
        raise InputError(f"{shown_path(file)} is no ELF image; name what the linker wrote, before objcopy")
    if header != _CORTEX_M:
        raise InputError(
            f"{shown_path(file)} is no linked image of 32 bits for Arm, little-endian; link it for Cortex-M, "
            "for example with arm-none-eabi-gcc -mcpu=cortex-m4 -mthumb"
        )
