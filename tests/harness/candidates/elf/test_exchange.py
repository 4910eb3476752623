"""Variables of an image that a manifest writes and reads, and functions that it answers."""

from __future__ import annotations

import ctypes
import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivegate.candidates.elf.loading import TargetController
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.duty.run import duty_nameplate
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.contract.duty.records import duty_command_record, duty_sense_record
from drivegate_models.errors import InputError

pytestmark = pytest.mark.needs("arm-none-eabi-gcc")

SOURCE = """
#include <stdint.h>
typedef struct { volatile uint32_t CCR[3], ARR; } TIM_TypeDef;
#define TIM1 ((TIM_TypeDef *)0x40010000)
typedef union { float value; uint8_t bytes[4]; } word;
struct { int16_t speed; word number; double exact; int64_t wide; uint64_t large; } in;
enum { OFF, ON } mode;
uint8_t level[3];
uint8_t grid[2][2];
int *pointer;
struct { int32_t half, nothing; float single; double twice; int64_t wide; } out;
int32_t period;
__attribute__((noinline)) int16_t half(void) { return *(volatile int16_t *)&in.speed; }
__attribute__((noinline)) float single(void) { return *(volatile float *)&in.number; }
__attribute__((noinline)) double twice(void) { return *(volatile double *)&in.exact; }
__attribute__((noinline)) int64_t wide(void) { return *(volatile int64_t *)&in.wide; }
__attribute__((noinline)) void nothing(void) { out.nothing++; }
void start(void) { TIM1->ARR = 8 * period; }
void isr(void) {
    out.half = half(), out.single = single(), out.twice = twice(), out.wide = wide();
    nothing();
    for (int leg = 0; leg < 3; leg++) TIM1->CCR[leg] = 100 * (leg + 1);
}
"""
TARGETS = {
    "hard": ("-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"),
    "soft": ("-mcpu=cortex-m0plus",),
}
DUTIES = {f"duty_ratios[{leg}]": f"TIM1.CCR[{leg}] / TIM1.ARR" for leg in range(3)}
NAMEPLATE = duty_nameplate(torque_scenario(load_drive("pm-ac-surface"), 100.0, (0.0,)))
Make = Callable[..., TargetController]


@pytest.fixture
def made(tmp_path: Path) -> Make:
    """Link an image, and load it by a manifest with the given tables."""

    def make(
        target: str = "hard", read: dict[str, object] | None = None, **tables: dict[str, object]
    ) -> TargetController:
        (tmp_path / "mine.c").write_text(SOURCE, encoding="utf-8")
        flags = (*TARGETS[target], "-mthumb", "-O1", "-g", "-nostartfiles", "-Wl,-e,0")
        places = ("-Wl,-Ttext=0x08000000", "-Wl,-Tdata=0x20000000")
        command = ["arm-none-eabi-gcc", *flags, *places, "-o", "mine.elf", "mine.c"]
        subprocess.run(command, cwd=tmp_path, check=True)
        lines = [
            'schema = 1\nname = "mine"\nkind = "elf"\nentry = "mine.elf"\ncontract = "duty"',
            'step = "isr"\nstart = "start"\nram = [[0x40010000, 0x1000]]',
        ]
        tables = {
            "peripherals": {"TIM1": "TIM_TypeDef(0x40010000)"},
            "write": {"period": 100},
            **tables,
            "read": DUTIES if read is None else read,
        }
        for name, table in tables.items():
            lines += [
                f"[{name}]",
                *(f"{json.dumps(key)} = {json.dumps(value)}" for key, value in table.items()),
            ]
        manifest = tmp_path / "candidate.toml"
        manifest.write_text("\n".join(lines), encoding="utf-8")
        loaded = load_controller(resolve_candidate(str(manifest)))
        assert isinstance(loaded, TargetController)
        return loaded

    return make


def answer(controller: TargetController, **sensed: float) -> Any:
    """Reset a controller, and step it once."""
    controller.reset(NAMEPLATE)
    currents = np.array([1.0, -2.0, 1.0])
    sense, command = duty_sense_record(currents), duty_command_record()
    # A NaN, which means no answer, would not be equal to itself.
    command["brake_duty"] = 0.0
    for name, value in sensed.items():
        sense[name] = value
    step = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)(controller.step_address)
    step(controller.state_address, sense.ctypes.data, command.ctypes.data)
    assert controller.fault is None
    return command[0]


def test_expressions_reach_registers_that_the_start_up_code_sees(made: Make) -> None:
    answered = answer(made())
    assert [answered[f"{leg}_duty"] for leg in ("first", "second", "third")] == [0.125, 0.25, 0.375]


@pytest.mark.parametrize("target", TARGETS)
def test_numbers_of_every_form_are_written_and_read(made: Make, target: str) -> None:
    write = {
        "period": 100,
        "in.speed": "speed",
        "in.number.value": "phase_currents[1] / 3",
        "in.exact": "nameplate.resistance - angle % 3",
        "in.wide": "-2 * supply_voltage * 1e9",
        "in.large": "1e30",
        "level[1]": "-speed",
        "level[2]": "max(abs(phase_currents[1]), floor(1.7), 0) + 0.6",
        "mode": "hall",
    }
    read = DUTIES | {
        "torque": "out.half",
        "angle": "out.single",
        "speed": "out.twice",
        "input_power": "out.wide",
        "next_period": "in.large",
        "fault": "mode + level[0] + level[1] + 10 * level[2] + in.number.bytes[3] * 1000",
    }
    answered = answer(made(target, read, write=write), speed=1e6, angle=8.0, supply_voltage=300.0, hall=5)
    assert answered["torque"] == 32767
    assert answered["angle"] == np.float32(-2.0 / 3.0)
    assert answered["speed"] == NAMEPLATE.resistance - 2.0
    assert answered["input_power"] == -600e9
    assert answered["next_period"] == np.nextafter(2.0**64, 0.0)
    # The third level is 2.6, rounded; the highest byte of a negative float has its sign.
    assert answered["fault"] == 5 + 30 + 0xBF * 1000


@pytest.mark.parametrize("target", TARGETS)
def test_a_function_is_answered_in_the_registers_of_its_type(made: Make, target: str) -> None:
    stub = {
        "half": "-7 - angle",
        "single": "angle / 3",
        "twice": "angle / 7",
        "wide": "-1e12 * angle",
        "nothing": 0,
    }
    outputs = ("half", "single", "twice", "wide", "nothing")
    channels = ("torque", "angle", "speed", "input_power", "fault")
    read = DUTIES | {channel: f"out.{name}" for channel, name in zip(channels, outputs, strict=True)}
    controller = made(target, read, stub=stub)
    answered = answer(controller, angle=2.0)
    expected = (-9.0, np.float32(2.0 / 3.0), 2.0 / 7.0, -2e12, 0)
    assert [answered[channel] for channel in channels] == [*expected]
    controller.watch_accesses()
    assert answer(controller, angle=2.0) == answered
    assert controller.taken_costs().instructions > 10


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("tables", "reason"),
    [
        ({"write": {"in.sped": 0}}, "mine: 'in.sped' has no field 'sped'; the nearest field is 'speed'"),
        ({"write": {"inn.speed": 0}}, "has no variable 'inn', the nearest one is 'in'"),
        ({"write": {"level[3]": 0}}, r"'level\[3\]' is outside of its array, which has 3 elements"),
        ({"write": {"grid[1]": 0}}, r"'grid\[1\]' is no number; name a field or an element of it"),
        ({"write": {"level": 0}}, "'level' is no number; name a field or an element of it"),
        (
            {"write": {"pointer.x": 0}},
            "'pointer.x' has no field 'x'",
        ),
        (
            {"write": {"TIM_TypeDef(0x50000000).ARR": 0}},
            "is at 5000000Ch, where the target has no memory; add it",
        ),
        ({"write": {"TIM(0x40010000).ARR": 0}}, "has no type 'TIM', the nearest one is"),
        ({"write": {"period": "curent"}}, "there is no signal 'curent', the nearest one is"),
        ({"write": {"period": "level[0]"}}, r"there is no signal 'level\[0\]'"),
        ({"write": {"period": "1 +"}}, r"candidate.toml: in \[write\], '1 \+' is no expression"),
        ({"write": {"1": "1"}}, r"in \[write\], '1' is no variable"),
        ({"read": {"duty": "period"}}, "a Command has no 'duty'; it has duty_ratios"),
        ({"read": {"torque": "period"}}, r"the table \[read\] has no duty_ratios\[0\], duty_ratios\[1\], "),
        (
            {"stub": {"hal": 0}},
            "mine has no function hal; an image has the functions that its manifest names",
        ),
        ({"peripherals": {"TIM1": "1"}}, r"in \[peripherals\], '1' is no variable"),
    ],
)
def test_what_the_image_does_not_have_is_one_sentence(
    made: Make, tables: dict[str, dict[str, object]], reason: str
) -> None:
    with pytest.raises(InputError, match=reason):
        made(**tables)  # type: ignore[arg-type]
