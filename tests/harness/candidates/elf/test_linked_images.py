"""Images as linkers make them: several segments in a page, initial values in flash, code in RAM."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from tests.harness.candidates.elf.conftest import DUTIES, Load

from drivegate_models.errors import InputError

pytestmark = pytest.mark.needs("arm-none-eabi-gcc")

SCRIPT = """
MEMORY {{ CCM (xrw): ORIGIN = 0x10000000, LENGTH = 64K  RAM (xrw): ORIGIN = 0x20000000, LENGTH = 64K
         FLASH (rx): ORIGIN = {flash}, LENGTH = 128K }}
SECTIONS {{
    .text : {{ *(.text*) *(.rodata*) }} > FLASH
    .init_array : {{ KEEP(*(.init_array*)) }} > FLASH
    .ARM.exidx : {{ *(.ARM.exidx*) }} > FLASH
    from = LOADADDR(.data); begins = ADDR(.data); ends = ADDR(.data) + SIZEOF(.data);
    .data : {{ *(.data*) {in_data} }} > RAM AT> FLASH
    .code : {{ *(.code*) }} > RAM AT> FLASH
    .ccm : {{ *(.ccm*) }} > CCM AT> FLASH
    .bss : {{ *(.bss*) *(COMMON) }} > RAM
    .kept (NOLOAD) : {{ *(.kept*) }} > RAM
    .heap : {{ . = . + 0x400; }} > RAM
}}
"""
SOURCE = """
#include <string.h>
extern char from[], begins[], ends[];
volatile int initial = 7;
int cleared;
const int constant = 11;
__attribute__((section(".ccm"))) int fast = 5;
__attribute__((section(".kept"))) int kept;
int answered, copied;
__attribute__((constructor)) static void construct(void) { cleared += 100; }
__attribute__((section(".code"), noinline, long_call)) static int in_ram(int value) { return value + kept + fast; }
void copy(void) { initial = 0; memcpy(begins, from, ends - begins); copied = initial; }
void isr(void) { answered = in_ram(initial + constant); kept++; cleared++; WRONG; }
"""
Script = Callable[..., tuple[str, ...]]
READ = {**DUTIES, "torque": "answered", "speed": "cleared", "angle": "kept", "input_power": "copied"}


@pytest.fixture
def script(tmp_path: Path) -> Script:
    def written(flash: str = "0x08000000", in_data: str = "") -> tuple[str, ...]:
        (tmp_path / "mine.ld").write_text(SCRIPT.format(flash=flash, in_data=in_data), encoding="utf-8")
        return ("-T", "mine.ld", "--specs=nosys.specs")

    return written


@pytest.mark.parametrize("flash", ["0x08000000", "0x00000000", "0x1FFFE000"])
@pytest.mark.parametrize("in_data", ["", "*(.code*)"])
def test_each_segment_has_its_memory_in_whatever_page(
    load: Load, script: Script, flash: str, in_data: str
) -> None:
    places = script(flash, in_data)
    loaded = load(SOURCE.replace("WRONG", ""), places=places, start=["copy", "construct"], read=READ)
    for _ in range(2):
        loaded.reset()
        answers = [loaded.step() for _ in range(3)]
        assert loaded.fault == ""
        assert [answer["torque"] for answer in answers] == [7 + 11 + 5 + count for count in range(3)]
        assert answers[2]["speed"] == 103, "a run does not see another's variables"
        assert answers[2]["input_power"] == 7, "start-up code finds the initial values in flash"


@pytest.mark.parametrize("wrong", ["*(volatile int *)&constant = 1", "*(volatile int *)copy = 1"])
def test_flash_that_shares_no_page_with_variables_is_read_only(
    load: Load, script: Script, wrong: str
) -> None:
    loaded = load(SOURCE.replace("WRONG", wrong), places=script(), read=READ).reset()
    loaded.step()
    assert "writes to the read-only address " in loaded.fault


def test_a_function_to_start_may_wait_where_steps_pause(load: Load) -> None:
    source = """
    int begun, count;
    void begin(void) { __asm__ volatile("wfi"); begun = 5; __asm__ volatile("wfi"); }
    int main(void) { for (;;) { __asm__ volatile("wfi"); count++; } }
    """
    read = {**DUTIES, "torque": "begun", "speed": "count"}
    loaded = load(source, step="main", start="begin", pause="wfi", read=read).reset()
    answered = loaded.step()
    assert (answered["torque"], answered["speed"]) == (5, 1)


def test_memory_of_the_manifest_may_overlap_the_image(load: Load, script: Script) -> None:
    wrong = "((volatile int *)0x20000000)[4000]++"
    loaded = load(
        SOURCE.replace("WRONG", wrong), places=script(), ram=[[0x20000000, 0x8000]], read=READ
    ).reset()
    assert loaded.step()["torque"] == 7 + 11 + 5
    assert loaded.fault == ""
    with pytest.raises(InputError, match="a piece of 'ram' ends beyond the last address"):
        load(SOURCE.replace("WRONG", ""), places=script(), ram=[[0xFFFFF000, 0x2000]], read=READ)
