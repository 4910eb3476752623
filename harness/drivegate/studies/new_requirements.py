"""A file of five usual requirements with the numbers of a drive, to be replaced by the user's own."""

from __future__ import annotations

from typing import Final

from drivegate_cases.documents.wording import figure, significant
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of, mechanical_time

_HEAD: Final = """\
schema = 1

# Your own requirements, next to the checks of drivegate: what this product must do.
# Put your numbers in place of these, and your sentences in place of `text`. Run them:
#   drivegate check CANDIDATE --requirements THIS-FILE
#
# when       the event after which a row is judged, or the state in which it is; left out, all of every run
# between_s  the judged window after the event; another change ends it
# quantity   what is limited, with its unit; `statistic` says what of it
# at_most    or at_least, or within = [low, high]
# level      "required" by default, or "advisory"
"""


def requirements_toml(drive: DriveDocument) -> str:
    """Write the file for a drive."""
    rows = [_settling(drive), _ripple(drive), _standstill(drive), _release(drive), _start(drive)]
    return "\n".join([_HEAD, *rows, _scenarios(drive)])


def _settling(drive: DriveDocument) -> str:
    limits = limits_of(drive)
    band, time = figure(limits.speed_tolerance_rpm), figure(limits.settling_s)
    return f"""\
# Settling after a load step: the time from which the speed stays in a band.
[[requirement]]
id = "REQ-1"
text = "After a load step the speed is back within {band} rpm in {time} s, and stays there."
when = "step of load"
quantity = "speed_deviation_rpm"
statistic = "time until"
until = [-{band}, {band}]
at_most = {time}
"""


def _ripple(drive: DriveDocument) -> str:
    limits = limits_of(drive)
    ripple = figure(2.0 * limits.speed_tolerance_rpm)
    return f"""\
# Speed ripple in a steady state: every 0.1 s from the settling time on. Windows can also be stated in control
# periods (between_periods), mechanical time constants (between_mechanical_times) and electrical periods.
[[requirement]]
id = "REQ-2"
text = "Once it has settled after a load step, the speed ripples by at most {ripple} rpm, peak to peak."
when = "step of load"
between_settling_times = [1.0]
for_s = 0.1
quantity = "speed_rpm"
statistic = "peak to peak"
at_most = {ripple}
"""


def _standstill(drive: DriveDocument) -> str:
    quantity = "current_a" if drive.may_be_held else "current_sum_a"
    phases = 1 if drive.may_be_held else drive.machine.phases
    limit = figure(significant(0.1 * phases * drive.rating.current_limit_a, 2))
    speed = figure(limits_of(drive).speed_tolerance_rpm)
    return f"""\
# Current in standstill: a state instead of an event. The scenario at the end of this file comes into it.
[[requirement]]
id = "REQ-3"
text = "At standstill without a load the drive takes at most {limit} A."
when = {{ speed_rpm = [-{speed}, {speed}], speed_reference_rpm = [0.0, 0.0], load_torque_nm = [0.0, 0.0] }}
between_settling_times = [1.0]
for_s = 0.05
quantity = "{quantity}"
statistic = "mean"
at_most = {limit}
"""


def _release(drive: DriveDocument) -> str:
    torque = figure(significant(0.1 * drive.rating.rated_torque_nm, 2))
    if drive.may_be_held:
        time = figure(significant(float(limits_of(drive).held_settling_s), 2))
        return f"""\
# Torque after release: the row waits for steps of the torque reference to 0 alone.
[[requirement]]
id = "REQ-4"
text = "{time} s after the throttle is released, the torque is at most {torque} N·m."
when = {{ event = "step of torque reference", torque_reference_nm = [0.0, 0.0] }}
between_s = [{time}]
for_s = 0.01
quantity = "torque_nm"
statistic = "mean"
within = [-{torque}, {torque}]
"""
    drop = figure(significant(0.2 * drive.rating.base_speed_rpm, 2))
    return f"""\
# Speed after the load is thrown off: a step of the load downward.
[[requirement]]
id = "REQ-4"
text = "When the load is thrown off, the speed rises by at most {drop} rpm."
when = {{ event = "step of load", step_percent = [-300.0, -10.0] }}
quantity = "speed_deviation_rpm"
at_most = {drop}
"""


def _start(drive: DriveDocument) -> str:
    speed = figure(0.5 * drive.rating.base_speed_rpm)
    band = figure(significant(0.05 * drive.rating.base_speed_rpm, 2))
    time = figure(_start_s(drive))
    return f"""\
# Start time: runs that begin at standstill with this speed as their reference.
[[requirement]]
id = "REQ-5"
text = "Without a load the shaft reaches {speed} rpm in {time} s."
when = {{ event = "start", speed_rpm = [0.0, 0.0], speed_reference_rpm = [{speed}, {speed}] }}
quantity = "speed_deviation_rpm"
statistic = "time until"
until = [-{band}, {band}]
at_most = {time}
"""


def _start_s(drive: DriveDocument) -> float:
    """Return a time in which half of base speed is reached with half of rated torque, and has settled (s)."""
    return significant(mechanical_time(drive) + float(limits_of(drive).settling_s), 2)


def _scenarios(drive: DriveDocument) -> str:
    """Write the scenarios that the plan of a check may not have: standstill, and a start without a load."""
    speed = figure(0.5 * drive.rating.base_speed_rpm)
    settling = float(limits_of(drive).settling_s)
    still, start = (
        figure(significant(2.0 * settling, 2)),
        figure(significant(1.5 * _start_s(drive) + settling, 2)),
    )
    load = 'load = { kind = "constant_torque", torque_nm = 0.0, factor = [[0.0, 1.0]] }'
    return f"""\
# Scenarios that are run for these requirements besides those of the check, on the drive that is checked.
[[scenario]]
name = "standstill"
duration_s = {still}
speed_rpm = [[0.0, 0.0]]
{load}

[[scenario]]
name = "start"
duration_s = {start}
initial_speed_rpm = 0.0
speed_rpm = [[0.0, {speed}]]
{load}
"""
