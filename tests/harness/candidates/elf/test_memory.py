"""Pages of a target: each is mapped once, with the rights of all that is in it."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from drivegate.candidates.elf.memory import PAGE, Stretch, areas_of, memory_at

STRETCHES = st.lists(
    st.builds(Stretch, st.integers(0, 20 * PAGE), st.integers(1, 3 * PAGE), st.booleans(), st.booleans()),
    min_size=1,
    max_size=12,
)


@given(STRETCHES)
def test_each_page_is_there_once_and_has_the_rights_of_all_that_is_in_it(stretches: list[Stretch]) -> None:
    expected: dict[int, tuple[bool, bool]] = {}
    for each in stretches:
        for page in range(each.address // PAGE, (each.address + each.size - 1) // PAGE + 1):
            writable, executable = expected.get(page, (False, False))
            expected[page] = writable or each.is_writable, executable or each.is_executable
    areas = areas_of(stretches)
    mapped = [
        (page, (run.is_writable, run.is_executable))
        for area in areas
        for run in area.stretches
        for page in range(run.address // PAGE, (run.address + run.size) // PAGE)
    ]
    assert mapped == sorted(expected.items())
    for each in stretches:
        assert memory_at(areas, each.address, each.size).size == each.size, (
            "a piece is one array, across rights"
        )


@given(STRETCHES)
def test_what_is_laid_into_pages_is_the_memory_that_the_emulator_maps(stretches: list[Stretch]) -> None:
    areas = areas_of(stretches)
    for area in areas:
        assert area.content.ctypes.data % PAGE == 0
        assert sum(run.size for run in area.stretches) == area.content.size
    memory_at(areas, stretches[0].address, 1)[:] = 7
    assert sum(int(area.content.sum()) for area in areas) == 7
