"""What a manifest reaches in an image as it is linked: by all versions of DWARF, and through pointers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.harness.candidates.elf.conftest import DUTIES, Load

from drivegate.candidates.elf.image import place_of, read_image
from drivegate.candidates.fault import CandidateFault
from drivegate_models.errors import InputError

pytestmark = pytest.mark.needs("arm-none-eabi-gcc")

SOURCE = """
#include <stdint.h>
typedef struct { volatile uint32_t DR, CR; } port;
struct node { struct node *next; int16_t values[3]; };
typedef struct { int32_t lock; port *Instance; struct node *chain; void *context; } handle;
handle hadc1;
static port registers;
struct node last, first;
extern uint16_t later[];
uint16_t later[3];
struct {
    int16_t tag;
    union { uint16_t both; struct { uint8_t low, high; }; };
    struct { int32_t deep; } named;
} mixed;
struct __attribute__((packed)) {
    uint32_t low : 3, : 2, mid : 12; int32_t negative : 5; uint32_t high : 10;
    uint8_t byte; uint64_t across : 20, wide : 33; _Bool is_on : 1;
} bits = {.negative = 3, .high = 1};
typedef struct { union { uint32_t all; struct { volatile uint32_t EN : 1, MODE : 2, DIV : 5; } b; }; } control;
static control unit = {0xFFFFFF00};
control *const device = &unit;
enum __attribute__((packed)) { SMALL, LARGE = 200 } size;
int32_t grid[2][3];
int32_t demand, begun, cleared = 7;
float *table;
static float cells[4];
struct { int32_t sum, both, grid; float table; int64_t bits; uint32_t device; } out;
void begin(void) {
    hadc1.Instance = &registers; hadc1.chain = &first; first.next = &last; table = cells;
    begun = demand; cleared = 0;
}
void isr(void) {
    out.sum = (int32_t)registers.DR + last.values[2] + later[1];
    out.both = mixed.both; out.grid = grid[1][2]; out.table = cells[3] + mixed.named.deep;
    out.bits = bits.low + 10 * bits.mid + 100000 * bits.negative + 10000000LL * bits.high;
    out.bits += bits.across == 0xABCDE && bits.wide == 0x123456789 && bits.is_on && bits.byte == 0;
    out.device = device->all;
    unit.b.MODE = 1;
    demand++;
}
int main(void) { return 0; }
"""
WRITE = {
    "hadc1.Instance->DR": "speed",
    "hadc1.chain.next->values[2]": 200,
    "later[1]": 3000,
    "mixed.low": "hall >> 1 & 0xF",
    "mixed.high": "(hall << 4 | 1) ^ 3",
    "mixed.named.deep": 8,
    "grid[1][2]": -77,
    "table[3]": 0.25,
    "size": 200,
}
READ = {
    **DUTIES,
    "torque": "out.sum + hadc1.Instance[0].DR / 1e6",
    "speed": "out.both",
    "angle": "out.grid + out.table",
    "input_power": "size",
}


@pytest.mark.parametrize(
    "debug",
    [
        "-gdwarf-2",
        "-gdwarf-2 -gstrict-dwarf",
        "-gdwarf-3",
        "-gdwarf-4",
        "-gdwarf-4 -fdebug-types-section",
        "-gdwarf-5",
        "-gdwarf-5 -fdebug-types-section",
        "-gdwarf-5 -gz",
    ],
)
def test_every_version_of_debug_information_leads_to_all_places(load: Load, debug: str) -> None:
    loaded = load(SOURCE, ("-O1", *debug.split()), start="begin", write=WRITE, read=READ).reset()
    answered = loaded.step(speed=5.0, hall=11)
    assert loaded.fault == ""
    assert answered["torque"] == 5 + 200 + 3000 + 5e-6
    assert answered["speed"] == (0b1011 >> 1 & 0xF) + 256 * (((11 << 4 | 1) ^ 3) & 0xFF)
    assert answered["angle"] == -77 + 0.25 + 8
    assert answered["input_power"] == 200
    image = read_image(loaded.file)
    assert "in isr (mine.c line " in place_of(image, image.functions["isr"])


BITS = {
    "bits.low": "speed + 7.4",
    "bits.mid": 4095,
    "bits.negative": -16,
    "bits.across": 0xABCDE,
    "bits.wide": 0x123456789,
    "bits.is_on": 1,
    "device->b.MODE": 3,
    "device->b.DIV": "angle",
}


@pytest.mark.parametrize("debug", ["-gdwarf-2", "-gdwarf-4", "-gdwarf-5"])
def test_a_bit_field_is_written_and_read_without_its_neighbors(load: Load, debug: str) -> None:
    read = {
        **DUTIES,
        "torque": "out.bits",
        "speed": "out.device",
        "angle": "bits.negative * 1000 + bits.low + bits.is_on / 2",
        "input_power": "bits.wide + device->b.MODE / 4",
    }
    loaded = load(SOURCE, ("-O1", debug), start="begin", write=BITS, read=read).reset()
    answered = loaded.step(speed=5.0, angle=40.0)
    assert loaded.fault == ""
    # Each is limited to its range, as 12 to 7 of three bits and 40 to 31 of five.
    assert answered["torque"] == 7 + 10 * 4095 - 16 * 100000 + 10000000 + 1
    assert answered["speed"] == 0xFFFFFF00 | 3 << 1 | 31 << 3
    assert answered["angle"] == -16 * 1000 + 7 + 0.5
    assert answered["input_power"] == 0x123456789 + 1 / 4


def test_a_value_is_written_once_and_remains_the_firmwares(load: Load) -> None:
    read = {**DUTIES, "torque": "begun", "speed": "demand", "angle": "cleared"}
    loaded = load(SOURCE, start="begin", once={"demand": 40, "cleared": 3}, read=read)
    for _ in range(2):
        loaded.reset()
        answers = [loaded.step() for _ in range(3)]
        assert [answer["torque"] for answer in answers] == [40] * 3, "start sees it"
        assert [answer["speed"] for answer in answers] == [41, 42, 43], "steps change it"
        assert answers[0]["angle"] == 3, "what start clears is written again"


def test_functions_to_start_are_called_in_their_order(load: Load) -> None:
    source = "int order; void a(void) { order = order * 10 + 1; } void b(void) { order = order * 10 + 2; }"
    source += "void isr(void) { order = order * 10 + 3; }"
    loaded = load(source, start=["a", "b", "a"], read={**DUTIES, "torque": "order"}).reset()
    assert loaded.step()["torque"] == 1213
    with pytest.raises(InputError, match="mine has no function nothing; an image has the functions"):
        load(source, start=["a", "nothing"])


STUBS = """
#include <stdint.h>
typedef struct { float alpha; int32_t counts[2]; } sample;
__attribute__((noinline)) int receive(int port, uint8_t *data, uint16_t size, uint32_t timeout) {
    while (size) size += port + data[0] + timeout;
    data[0] = 1, data[1] = 1;
    return 1;
}
__attribute__((noinline)) void measure(float scale, sample *into, double exact, float more) {
    into->alpha = scale + exact + more, into->counts[1] = 1;
}
__attribute__((noinline)) int32_t far(int a, int64_t b, int c, int d, int16_t *e) { return a + b + c + d + ++*e; }
struct { int32_t status, first, second, far, e; float alpha; int32_t counts; } out;
void isr(void) {
    uint8_t data[2] = {0, 0};
    sample taken = {0};
    int16_t last = 0;
    out.status = receive(3, data, 2, 100);
    out.first = data[0]; out.second = data[1];
    measure(1.5f, &taken, 2.0, 4.5f);
    out.alpha = taken.alpha; out.counts = taken.counts[1];
    out.far = far(1, 2, 3, 4, &last); out.e = last;
}
"""


@pytest.mark.parametrize("debug", ["-gdwarf-2", "-g"])
@pytest.mark.parametrize("abi", ["-mfloat-abi=hard", "-mfloat-abi=softfp"])
def test_a_stub_fills_what_it_is_passed_and_answers_by_its_arguments(
    load: Load, debug: str, abi: str
) -> None:
    stub = {
        "receive": {"returns": "size + timeout", "fills": {"data[0]": "hall >> 8", "data[1]": "hall & 0xFF"}},
        "measure": {"fills": {"into->alpha": "scale + exact * more", "into.counts[1]": "hall"}},
        "far": {"returns": "10 * a + d", "fills": {"e[0]": "b + c"}},
    }
    channels = ("torque", "speed", "angle", "input_power", "fault", "next_period")
    fields = ("status", "first + 1000 * out.second", "alpha", "counts", "far", "e")
    read = {**DUTIES, **{channel: f"out.{field}" for channel, field in zip(channels, fields, strict=True)}}
    loaded = load(STUBS, ("-O1", debug, abi), stub=stub, read=read).reset()
    answered = loaded.step(hall=0x1234)
    assert loaded.fault == ""
    assert [answered[channel] for channel in channels] == [102, 0x12 + 1000 * 0x34, 10.5, 0x1234, 14, 5]


def test_a_pointer_to_no_memory_is_one_sentence(load: Load) -> None:
    write = {"hadc1.Instance->DR": "speed"}
    with pytest.raises(
        InputError, match=r"mine leaves a pointer .* where \[write\] names 'hadc1.Instance.DR'; 'start'"
    ):
        load(SOURCE, write=write).reset()
    lost = SOURCE.replace("demand++;", "hadc1.Instance = (port *)0x50000000;")
    loaded = load(lost, start="begin", write=write).reset()
    loaded.step()
    loaded.step()
    assert "leaves a pointer that points to no memory of the target, where [write] names" in loaded.fault
    read = {**DUTIES, "torque": "hadc1.Instance.DR"}
    loaded = load(lost, start="begin", read=read).reset()
    loaded.step()
    assert "where [read] names 'torque'" in loaded.fault or "'hadc1.Instance.DR'" in loaded.fault
    wild = STUBS.replace("receive(3, data,", "receive(3, (uint8_t *)4,")
    loaded = load(wild, stub={"receive": {"fills": {"data[0]": 1}}}).reset()
    loaded.step()
    assert "passes a pointer to no memory of the target: 'data[0]' in [stub], in receive" in loaded.fault


@pytest.mark.parametrize(
    ("tables", "reason"),
    [
        ({"write": {"hadc1.Instance.DX": 0}}, "has no field 'DX'; the nearest field is 'DR'"),
        ({"write": {"hadc1.context.DR": 0}}, "leads through a pointer to a type without fields"),
        ({"write": {"grid[1]": 0}}, r"'grid\[1\]' is no number"),
        ({"write": {"grid[1][3]": 0}}, r"'grid\[1\]\[3\]' is outside of its array, which has 3 elements"),
        ({"write": {"later[3]": 0}}, r"'later\[3\]' is outside of its array, which has 3 elements"),
        ({"stub": {"begin": {"fills": {"data[0]": 0}}}}, "has no variable 'data'"),
        ({"stub": {"begin": {"fils": {}}}}, "fils"),
        ({"once": {"deman": 0}}, "has no variable 'deman', the nearest one is 'demand'"),
        ({"once": {"demand": "1 <"}}, r"in \[once\], '1 <' is no expression"),
        ({"write": {"demand": "hall and 1"}}, "is not allowed|is no expression"),
    ],
)
def test_what_is_not_there_is_one_sentence(load: Load, tables: dict[str, Any], reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        load(SOURCE, **tables)


def test_bits_of_numbers_are_those_of_integers(load: Load) -> None:
    source = "#include <stdint.h>\nint32_t low, high; uint16_t whole; void isr(void) {}"
    write = {"low": "angle * 1000 & 255", "high": "angle * 1000 >> 8", "whole": "angle * 1000"}
    read = {**DUTIES, "torque": "high * 256 + low - whole", "speed": "~low", "angle": "-1 >> 3 << 2"}
    loaded = load(source, write=write, read=read).reset()
    for angle in np.linspace(0.0, 6.28, 50):
        answered = loaded.step(angle=float(angle))
        assert answered["torque"] == 0, "rounded as a store does"
        assert answered["speed"] == -1 - (round(float(angle) * 1000) & 255)
    assert answered["angle"] == -4


def test_a_super_loop_goes_on_where_it_has_paused(load: Load) -> None:
    source = """
    int begun, count, due, seen;
    __attribute__((noinline)) void idle(void) { __asm__ volatile("wfi"); }
    int main(void) {
        begun = 1 + due;
        for (int round = 0;; round++) {
            WAIT;
            if (due) { due = 0; count++; }
            seen = round;
            if (count == 4) return 0;
        }
    }
    """
    read = {**DUTIES, "torque": "count", "speed": "begun", "angle": "seen"}
    for wait, pause in (("idle()", "idle"), ('__asm__ volatile("wfi")', "wfi")):
        loaded = load(source.replace("WAIT", wait), step="main", pause=pause, write={"due": 1}, read=read)
        for _ in range(2):
            loaded.reset()
            answers = [loaded.step() for _ in range(3)]
            assert [answer["torque"] for answer in answers] == [1, 2, 3]
            assert [answer["angle"] for answer in answers] == [0, 1, 2]
            assert answers[0]["speed"] == 2, "what it reads at its begin is written"
        loaded.step()
        assert "returns before it pauses" in loaded.fault
    with pytest.raises(CandidateFault, match="million instructions without coming to an end, in main"):
        load(source.replace("WAIT", ""), step="main", pause="idle").reset()


def test_a_static_variable_within_a_function_is_named_with_the_function(load: Load) -> None:
    source = """
    int answered;
    void isr(void) { if (answered >= 0) { static volatile int ramp = 5; ramp++; answered = ramp; } }
    """
    read = {**DUTIES, "torque": "answered", "speed": "isr::ramp"}
    loaded = load(source, write={"isr::ramp": "enable * 20"}, read=read).reset()
    answered = loaded.step(enable=1)
    assert (answered["torque"], answered["speed"]) == (21, 21)
    with pytest.raises(InputError, match="has no variable 'isr::slope', the nearest one is"):
        load(source, read={**DUTIES, "speed": "isr::slope"})


def test_debug_information_in_other_files_is_named(load: Load) -> None:
    with pytest.raises(
        InputError, match="has its debug information in other files; compile it without -gsplit-dwarf"
    ):
        load("int sum; void isr(void) { sum++; }", ("-g", "-gsplit-dwarf"), read={**DUTIES, "speed": "sum"})


INLINED = """
volatile int ticks; static int gain = 3; float rate;
int now(void) { return ticks; }
static int poll(void) { return ticks + 1; }
void wait(int count) { int begin = now(); while (now() - begin < count) {} }
void isr(void) { ticks = gain * poll(); LATER }
"""


@pytest.mark.parametrize(
    ("later", "flags", "tables", "reason"),
    [
        (
            "",
            ("-O2", "-g"),
            {"stub": {"now": 0}},
            "'now' in .stub. is inlined into wait, which no stub reaches",
        ),
        (
            "rate = now();",
            ("-O2", "-g"),
            {"stub": {"now": 0, "wait": 0}},
            "is inlined into isr, which no stub reaches",
        ),
        (
            "",
            ("-O2", "-g"),
            {"stub": {"poll": 0}},
            "The compiler has inlined it into isr: mark 'poll' __attribute__",
        ),
        (
            "",
            ("-O2", "-g"),
            {"write": {"gain": 1}},
            "no variable 'gain' in memory: the compiler has made a constant of",
        ),
        (
            "",
            ("-O2", "-g1"),
            {"write": {"ticks": 1}},
            "no type of the variable 'ticks'; compile its source with -g,",
        ),
        (
            "",
            ("-mcpu=cortex-m55",),
            {},
            "built for Armv8.1-M, .* the emulator does not have; build it with -mcpu=",
        ),
    ],
)
def test_what_the_compiler_has_done_is_named(
    load: Load, later: str, flags: tuple[str, ...], tables: dict[str, Any], reason: str
) -> None:
    with pytest.raises(InputError, match=reason):
        load(INLINED.replace("LATER", later), flags=flags, **tables)


def test_a_function_that_is_inlined_into_answered_ones_alone_is_answered(load: Load) -> None:
    source = INLINED.replace("LATER", "wait(5); rate = 2;")
    waits = source.replace("void wait", "__attribute__((noinline)) void wait")
    loaded = load(waits, flags=("-O2", "-g"), stub={"now": 0, "wait": 0}, read={**DUTIES, "torque": "rate"})
    assert loaded.reset().step()["torque"] == 2


@pytest.mark.parametrize("suffix", ["axf", "out", ""])
def test_an_image_may_have_the_suffix_of_other_tools(load: Load, suffix: str) -> None:
    loaded = load("void isr(void) {}", suffix=suffix).reset()
    loaded.step()
    assert loaded.fault == ""
