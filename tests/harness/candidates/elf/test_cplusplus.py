"""What a manifest names in an image of C++: by namespaces and classes, as in the source."""

from __future__ import annotations

import re

import pytest
from tests.harness.candidates.elf.conftest import DUTIES, Load

from drivegate_models.errors import InputError

pytestmark = pytest.mark.needs("arm-none-eabi-gcc")

CPLUSPLUS = ("-x", "c++", "-O2", "-g", "-std=c++17", "-fno-exceptions", "-fno-rtti")
SOURCE = """
struct Timer { volatile unsigned CCR1; };
namespace board { struct Port { volatile unsigned DR; } spare; namespace { volatile int hidden; } }
namespace control {
template <typename T, int N> struct Filter { T state[N]; };
class Motor {
  public:
    static volatile int count;
    float reference = 1.0F;
    float &alias = reference;
    Filter<float, 2> filter;
    virtual void run();
  private:
    int offset = 5;
};
volatile int Motor::count = 3;
volatile int total;
void Motor::run() { count = count + offset; }
Motor motor;
void wait(int periods) { while (periods) { } }
__attribute__((noipa)) static int measured(int channel) { for (volatile int i = 0;; i = i + channel) { } }
void begin() { board::hidden = 7; wait(3); }
void isr() { motor.run(); total = total + 1 + board::hidden; motor.filter.state[1] += measured(1); }
}
namespace axis {
volatile int total = 40;
struct Motor { static volatile int count; };
volatile int Motor::count = 9;
}
extern "C" void (*__init_array_start[])(), (*__init_array_end[])();
void construct() { for (auto each = __init_array_start; each < __init_array_end; each++) (*each)(); }
void overloaded(int) { }
void overloaded(float) { }
"""
KEYS = {
    "step": "control::isr",
    "start": ["construct", "control::begin"],
    "ram": [[0x40000000, 0x1000]],
    "peripherals": {"PORT": "board::Port(0x40000000)"},
    "write": {"control::motor.alias": "reference", "PORT.DR": 4, "control::motor.filter.state[0]": 2},
    "stub": {"control::wait": 0, "control::measured": {"returns": "channel + 10", "fills": {}}},
    "read": {
        **DUTIES,
        "torque": "control::Motor::count",
        "speed": "control::total + 100 * axis::total",
        "angle": "motor.reference + motor.filter.state[1] + PORT.DR",
        "input_power": "hidden",
    },
}


def test_names_of_the_source_reach_variables_types_and_functions(load: Load) -> None:
    loaded = load(SOURCE, CPLUSPLUS, **KEYS).reset()
    loaded.step(reference=2.0)
    answered = loaded.step(reference=2.0)
    assert loaded.fault == ""
    assert answered["torque"] == 3 + 2 * 5
    assert answered["speed"] == 2 * 8 + 100 * 40
    assert answered["angle"] == 2.0 + 2 * 11 + 4
    assert answered["input_power"] == 7


def test_a_last_name_that_several_have_is_refused(load: Load) -> None:
    read = {**DUTIES, "torque": "total"}
    message = "has several variables 'total': 'control::total' and 'axis::total'; name one of them"
    with pytest.raises(InputError, match=re.escape(message)):
        load(SOURCE, CPLUSPLUS, **{**KEYS, "read": read})


def test_of_overloaded_functions_none_is_chosen(load: Load) -> None:
    with pytest.raises(InputError, match="has no function overloaded"):
        load(SOURCE, CPLUSPLUS, **{**KEYS, "step": "overloaded"})


def test_what_the_compiler_has_made_of_a_function_is_named(load: Load) -> None:
    source = """
    __attribute__((noinline)) static int scaled(int factor, int *sum) { return factor * *sum; }
    int sum = 3, product;
    void isr(void) { product = scaled(7, &sum); }
    """
    message = r"has no function scaled; .*\. The compiler has made 'scaled\..*' of one: mark it __attribute__"
    with pytest.raises(InputError, match=message):
        load(source, ("-O2", "-g"), stub={"scaled": 1})
