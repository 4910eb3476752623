"""The rate of gym-electric-motor: a three-phase PM machine behind a finite-set bridge with hysteresis comparators.

Run it with a Python in which gym-electric-motor 3 is installed; it needs nothing else and prints one JSON object. The
job is not drivegate's: three phases and sinusoidal EMF at fixed speed, comparators that look once in 10 µs, and a
reward with every step.
"""

import json
import sys
import time
import warnings
from importlib.metadata import PackageNotFoundError, version

STEPS = 10_000
SPEED = 157.0
PEAK_A = 60.0


def comparators(currents, references, gates):
    """Switch a leg on below its reference and off above it; 2 A apart."""
    for phase, (current, reference) in enumerate(zip(currents, references, strict=True)):
        if current > reference + 1.0:
            gates[phase] = 0
        elif current < reference - 1.0:
            gates[phase] = 1
    return 4 * gates[0] + 2 * gates[1] + gates[2]


def main():
    """Measure and print."""
    try:
        installed = version("gym-electric-motor")
    except PackageNotFoundError:
        sys.stderr.write("gym-electric-motor is not installed in this Python: not measured\n")
        return
    warnings.simplefilter("ignore")
    import gym_electric_motor
    import numpy as np
    from gym_electric_motor.physical_systems import ConstantSpeedLoad

    environment = gym_electric_motor.make(
        "Finite-CC-PMSM-v0",
        load=ConstantSpeedLoad(omega_fixed=SPEED),
        constraints=(),
        visualization=None,
    ).unwrapped
    system = environment.physical_system
    names = system.state_names
    places = [names.index(name) for name in ("i_a", "i_b", "i_c")]
    limits, epsilon = system.limits, names.index("epsilon")
    shifts = np.array([0.0, 2.0, 4.0]) * np.pi / 3.0
    (state, _), _ = environment.reset(seed=0)
    gates, errors = [0, 0, 0], []
    began = time.process_time()
    for step in range(STEPS):
        currents = state[places] * limits[places]
        angle = state[epsilon] * limits[epsilon]
        references = -PEAK_A * np.sin(angle - shifts)
        (state, _), _, _, _, _ = environment.step(comparators(currents, references, gates))
        if step > STEPS // 10:
            errors.append(float(np.abs(currents - references).max()))
    seconds = time.process_time() - began
    mean = sum(errors) / len(errors)
    row = {
        "peer": "gym-electric-motor",
        "version": installed,
        "job": f"3 phases, hysteresis, {1e6 * system.tau:g} µs steps",
        "times_real_time": STEPS * system.tau / seconds,
        "valid": mean < 0.2 * PEAK_A,
        "check": f"currents follow within {mean:.1f} A of {PEAK_A:g} A in the mean",
    }
    sys.stdout.write(json.dumps(row, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
