"""Which signals a condition in a source depends on, as far as its text shows that."""

import time

import pytest

from drivegate.contracts.catalogue import all_contracts
from drivegate.output.code_conditions import Conditions
from drivegate_models.contract.layout import CURRENT, DUTY

KEYS = {"supply_voltage": "link_voltage_v", "enable": "restarts_s", "speed": "speed_rpm"}
SOURCE = """
    if (!sense->enable) return;
    real supply = fmax((real)sense->supply_voltage, 1e-9), limit = supply / ROOT_THREE;
    self->weak = limit - used; /* sense->enable has no part in it */
    if (self->weak < 0.0) return;
    if (self->enable_count) return;
    speed = sense.speed
static double limited(double value, double top) {
    clarke(sense->supply_voltage, &alpha, &self->beta);
    return limited(fmax(sense->supply_voltage, 1.0), 3.0);
    first, second = sense.speed, 0.0
fn bounded(level: f64) -> f64 {
    let x = bounded(sense.enable);
""".splitlines()


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("if (!sense->enable) return;", "enable: restarts_s"),
        ("if (self->weak < 0.0) return;", "supply_voltage: link_voltage_v"),
        ("if speed > 3.0 and not sense.enable:", "enable: restarts_s; speed: speed_rpm"),
        ("if (self->enable_count) return;", ""),
        ("if (other) return; // sense->enable", ""),
        ("if (self->beta > alpha)", "supply_voltage: link_voltage_v"),
        ("return value > other", "supply_voltage: link_voltage_v"),
        ("if (top > 0.0)", ""),
        ("if second > 3.0:", "speed: speed_rpm"),
        ("if level > 3.0 {", "enable: restarts_s"),
    ],
)
def test_a_condition_names_the_signals_that_it_depends_on(line: str, hint: str) -> None:
    assert Conditions(SOURCE, KEYS).hint(line) == hint


def test_every_contract_says_what_moves_its_signals() -> None:
    """All but what the harness sets, which no scenario moves."""
    fixed = {"current": {"struct_size", "phase_count"}, "duty": {"struct_size"}}
    layouts = {"current": CURRENT, "duty": DUTY}
    for contract in all_contracts():
        fields = {*layouts[contract.name].signals._fields, "phase_currents"}
        assert fields - fixed[contract.name] == set(contract.moved_by)


def test_a_long_line_is_looked_at_at_once() -> None:
    """Hostile sources may have any."""
    began = time.process_time()
    hostile = [word * 40_000 for word in ("a", "a ", "a,", "f(", "&a,")]
    assert Conditions(hostile, KEYS).hint("/*" * 40_000) == ""
    assert time.process_time() - began < 2.0
