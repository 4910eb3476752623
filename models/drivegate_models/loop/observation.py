"""What the closed loop keeps of a run: fixed numbers, whatever the run's length.

Two arrays of totals: one for the whole run, one row for each observed window of it.
"""

from typing import Final

RUN_STEPS: Final = 0
"""Control periods done."""
RUN_REFERENCE_LOWEST: Final = 1
"""Least current reference that the candidate asked for (A), before clamping."""
RUN_REFERENCE_HIGHEST: Final = 2
"""Greatest (A)."""
RUN_ANGLE_LOWEST: Final = 3
"""Least advance angle that the candidate asked for (rad), before clamping."""
RUN_ANGLE_HIGHEST: Final = 4
"""Greatest (rad)."""
RUN_ANGLE_BELOW_BASE: Final = 5
"""Greatest magnitude of the advance angle in steps whose Sense showed less than base speed (rad)."""
RUN_STEPS_BELOW_BASE: Final = 6
"""Number of those steps."""
RUN_POWER_ESTIMATES: Final = 7
"""Number of input power estimates."""
RUN_POWER_ERROR: Final = 8
"""Greatest difference of an estimate from measured supply voltage times measured current sum, or from the mean of
that product over the window that the candidate declares (W)."""
RUN_POWER_ERROR_RELATIVE: Final = 9
"""The same over that product, where it exceeds 1 W (1)."""
RUN_EXCHANGE_ERROR: Final = 10
"""Greatest difference of net supply energy, `EXCHANGED` - 2 `RETURNED`, from where it went, over `EXCHANGED`."""
RUN_KINETIC_RESIDUAL: Final = 11
"""Sum of ``J (change of speed)**2 / 2``, what freezing the speed within a period leaves out (J)."""
RUN_SHAFT_ENERGY: Final = 12
"""Sum of speed times electromagnetic impulse (J)."""
RUN_INPUT_ENERGY: Final = 13
"""Net energy taken from the supply, core and switching losses included (J)."""
RUN_FIRST_BELOW_BASE: Final = 14
"""Time of the step of `RUN_ANGLE_BELOW_BASE` (s)."""
RUN_SPEED_FINAL: Final = 15
"""Speed at the end (rad/s)."""
RUN_ENTRIES: Final = 16
"""Length of the run's array."""

WINDOW_STEPS: Final = 0
"""Control periods in the window."""
WINDOW_SPEED_ERROR: Final = 1
"""Greatest magnitude of the true speed error (rad/s)."""
WINDOW_ANGLE_LOWEST: Final = 2
"""Least advance angle (rad), as applied."""
WINDOW_ANGLE_HIGHEST: Final = 3
"""Greatest (rad)."""
WINDOW_MEAN_LOWEST: Final = 4
"""Least 100 ms mean of the current sum (A)."""
WINDOW_MEAN_HIGHEST: Final = 5
"""Greatest (A)."""
WINDOW_CURRENT_SUM: Final = 6
"""Mean of the current sum (A)."""
WINDOW_TORQUE: Final = 7
"""Mean electromagnetic torque (N m)."""
WINDOW_INPUT_POWER: Final = 8
"""Mean net input power, all losses included (W)."""
WINDOW_EXCHANGED_POWER: Final = 9
"""Mean power exchanged with the half-sources (W)."""
WINDOW_ANGLE: Final = 10
"""Mean advance angle (rad)."""
WINDOW_REFERENCE: Final = 11
"""Mean current reference (A), as applied."""
WINDOW_SPEED: Final = 12
"""Mean speed (rad/s)."""
WINDOW_PEAK: Final = 13
"""Greatest phase current (A)."""
WINDOW_RIPPLE: Final = 14
"""Torque ripple, peak to peak over mean, of the worst electrical period in the window's last `RIPPLE_TIME` (1)."""
WINDOW_RIPPLE_ONE_SIDED: Final = 15
"""Greatest deviation from the mean over the mean, of the worst electrical period there (1)."""
WINDOW_ENTRIES: Final = 16
"""Length of a window's row."""

MEAN_TIME: Final = 0.1
"""Length of the means of the current sum (s)."""

RIPPLE_TIME: Final = 1.0
"""Time at a window's end in which the torque's extremes are followed (s)."""

TRACE_COLUMNS: Final = (
    "time_s",
    "speed_reference_rpm",
    "speed_rpm",
    "current_sum_a",
    "current_reference_a",
    "advance_deg",
    "torque_nm",
    "load_torque_nm",
    "input_power_w",
    "half_supply_v",
    "measured_speed_rpm",
)
"""Columns of a trace, in people's units; one row for each kept control period."""
