"""What runs reach of an image: lines of its sources, by the blocks of instructions that the emulator runs."""

from __future__ import annotations

from pathlib import Path

import pytest
from elftools.elf.elffile import ELFFile
from tests.harness.candidates.elf.conftest import Load, Loaded

from drivegate.candidates.elf.loading import TargetController
from drivegate.candidates.kinds import KINDS, load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate_models.errors import InputError

pytestmark = pytest.mark.needs("arm-none-eabi-gcc")

SOURCE = """volatile int steps, limit = 2, trips;
static int rare(int value) {
    return value * 7;
}
void isr(void) {
    steps++;
    if (steps > limit)
        trips = rare(steps);
    if (steps > 100) trips = 3; /* GCOVR_EXCL_LINE */
}
int main(void) { return 0; }
"""


@pytest.mark.parametrize("version", [4, 5])
def test_lines_that_ran_are_read_from_all_processes(load: Load, tmp_path: Path, version: int) -> None:
    flags = ("-O0", "-g", f"-gdwarf-{version}")
    loaded = load(SOURCE, flags, sources=["mine.c"])
    plain = resolve_candidate(str(tmp_path / "candidate.toml"))
    folder, output = tmp_path / "counted", tmp_path / "output"
    folder.mkdir()
    output.mkdir()
    candidate = KINDS["elf"].counted_candidate(plain, folder)
    controller = load_controller(candidate)
    assert isinstance(controller, TargetController)
    counted = Loaded(controller, loaded.file).reset()
    for _ in range(2):
        counted.step()
    controller.write_counters()
    counts = {line.number: line.count for line in KINDS["elf"].measured_files(candidate, output)[0].lines}
    assert counts[6] == counts[7] == 1
    assert counts[8] == counts[3] == 0
    assert 9 not in counts
    assert "DA:8,0" in (output / "coverage.info").read_text()
    assert "<coverage" in (output / "coverage.xml").read_text()


def test_an_image_without_lines_is_refused(load: Load, tmp_path: Path) -> None:
    load(SOURCE, ("-O1",), sources=["mine.c"])
    with pytest.raises(InputError, match="compile it with -g, and name its sources"):
        KINDS["elf"].counted_candidate(resolve_candidate(str(tmp_path / "candidate.toml")), tmp_path)


def test_damaged_debug_information_is_refused_in_one_sentence(load: Load, tmp_path: Path) -> None:
    loaded = load(SOURCE, ("-O0", "-g"), sources=["mine.c"])
    candidate = resolve_candidate(str(tmp_path / "candidate.toml"))
    content = loaded.file.read_bytes()
    with loaded.file.open("rb") as stream:
        section = ELFFile(stream).get_section_by_name(".debug_abbrev")
        begin, end = section["sh_offset"], section["sh_offset"] + section["sh_size"]
    loaded.file.write_bytes(content[:begin] + b"\x7f" * (end - begin) + content[end:])
    with pytest.raises(
        InputError, match=r"cannot read the debug information of the image: .*; compile and link it"
    ):
        KINDS["elf"].counted_candidate(candidate, tmp_path)
