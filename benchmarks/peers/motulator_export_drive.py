"""The rate of motulator-export: motulator's drive and its controller, compiled from C.

Run it with a Python in which motulator-export 0.11 or a later version is installed, and with gcc on the path; it prints
one JSON object. The drive is that of `motulator_drive.py`, and so is what differs from drivegate's job. It is compiled
and run once before it is timed. The rate is that of its compiled loop alone; a call as users make it also turns what
the loop kept into results, in Python, and is reported beside it.
"""

import json
import sys
import time
from importlib.metadata import PackageNotFoundError, version

from motulator_drive import LOAD_NM, SPEED, drive

SIMULATED_S = 4.0
ROUNDS = 5


def simulated(dead_time=0.0):
    """Simulate a drive of a dead time (s); return the processor times of loop and call, and the speed at the end."""
    from motulator_export import native
    from motulator_export.native._system import NativeSystem

    seconds = []
    run = NativeSystem.run

    def timed(*words):
        began = time.process_time()
        status = run(*words)
        seconds.append(time.process_time() - began)
        return status

    plant, system = drive(dead_time)
    # Constants cost it the least time.
    system.set_speed_ref(SPEED)
    plant.mechanics.set_external_load_torque(LOAD_NM)
    simulation = native.Simulation(plant, system, show_progress=False)
    NativeSystem.run = timed
    began = time.process_time()
    try:
        results = simulation.simulate(t_stop=SIMULATED_S)
    finally:
        NativeSystem.run = run
    return sum(seconds), time.process_time() - began, float(results.mdl.mechanics.w_M[-1])


def main():
    """Measure and print."""
    try:
        installed = version("motulator-export")
    except PackageNotFoundError:
        sys.stderr.write("motulator-export is not installed in this Python: not measured\n")
        return
    simulated()
    rounds = [simulated() for _ in range(ROUNDS)]
    loop, whole, speed = map(min, zip(*rounds, strict=True))
    row = {
        "peer": "motulator-export",
        "version": installed,
        "job": "the same, compiled from C",
        "times_real_time": SIMULATED_S / loop,
        "valid": abs(speed - SPEED) < 1.0,
        "check": f"ends at {speed:.2f} of {SPEED:.2f} rad/s; {SIMULATED_S / whole:.2f} with its results",
    }
    sys.stdout.write(json.dumps(row, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
