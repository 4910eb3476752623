"""The signals between the harness and a candidate controller, in Python.

They are plain named tuples of floats, so that a controller needs no library to read them. The same signals as binary
records for compiled controllers are in `drivegate_models.contract.current.records`.
"""

from typing import Final, NamedTuple

HALF_BRIDGE: Final = 1
"""Kind of drive: decoupled phases, each on a half-bridge leg at a split supply."""
STAR: Final = 2
"""Kind of drive: star connection with an isolated neutral, trapezoidal EMF."""
PM_AC: Final = 3
"""Kind of drive: star connection, sinusoidal EMF."""


class Sense(NamedTuple):
    """The controller's input at the start of a control period."""

    time: float
    """Simulated time; it grows by a control period from step to step, and need not begin at 0 (s)."""
    speed_reference: float
    """Reference speed of the shaft (rad/s)."""
    speed: float
    """Measured speed of the shaft (rad/s)."""
    phase_currents: tuple[float, ...]
    """Measured phase currents at this instant, one per phase (A)."""
    current_magnitude_sum: float
    """Sum of the magnitudes of the phase currents, averaged over the control period just ended (A)."""
    half_supply_voltage: float
    """Measured voltage of one half of the split supply (V)."""


class Command(NamedTuple):
    """The controller's output: the commands for the control period that begins."""

    current_reference: float
    """Amplitude maintained by the phase current regulators (A), from 0 to the nameplate's current limit."""
    advance_angle: float
    """Advance of the conduction windows (electrical rad), from 0 to π/2."""
    input_power: float = float("nan")
    """The controller's own estimate of its input power (W); NaN for none."""


class Nameplate(NamedTuple):
    """The controller's knowledge of its drive before a run.

    The machine's parameters are the nominal ones; the drive in the run may differ.
    """

    phases: int
    """Number of phases."""
    pole_pairs: int
    """Number of pole pairs."""
    half_supply_voltage: float
    """Nominal voltage of one half of the split supply (V)."""
    base_speed: float
    """Shaft speed above which the advance angle may leave zero (rad/s)."""
    rated_power: float
    """Rated mechanical power (W)."""
    current_limit: float
    """Maximum current reference (A)."""
    control_period: float
    """Time from one step to the next (s)."""
    hysteresis_band: float
    """Half width of the current regulators' band (A)."""
    resistance: float
    """Nominal phase resistance (Ω)."""
    inductance: float
    """Nominal phase inductance (H)."""
    emf_constant: float
    """Nominal amplitude of the phase EMF over the shaft speed (V·s/rad)."""
    inertia: float
    """Nominal moment of inertia at the shaft (kg·m²)."""
    kind: int
    """Kind of drive: `HALF_BRIDGE`, `STAR` or `PM_AC`."""
    window: float
    """Conduction angle of a phase in each half cycle (electrical rad)."""
    conducting_phases: float
    """Mean number of conducting phases: phases · window / π."""
    advance_start: float
    """Angle at base speed of the drive's recommended line of advance angles (electrical rad)."""
    advance_slope: float
    """Slope of that line over the speed of the shaft (electrical rad per rad/s)."""
    highest_speed: float
    """Shaft speed up to which rated power is required (rad/s)."""
