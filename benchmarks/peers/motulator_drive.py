"""The rate of motulator: a three-phase 2.2 kW drive with carrier PWM under sensored vector control.

Run it with a Python in which motulator 0.18 or a later version is installed; it needs nothing else and prints one JSON
object. The job is not drivegate's: three phases and sinusoidal EMF, PWM of fixed frequency in place of hysteresis
comparators, and an adaptive solver between the switching instants in place of a closed form.
"""

import json
import sys
import time
from importlib.metadata import PackageNotFoundError, version

SIMULATED_S = 0.5
SPEED = 100.0
LOAD_NM = 9.8
LOAD_STEP_S = 0.2


def drive(dead_time=0.0):
    """Return the drive, of a dead time (s), and its controller, which motulator-export simulates too."""
    import motulator.drive.control.sm as control
    from motulator.drive import model

    parameters = model.SynchronousMachinePars(n_p=3, R_s=3.6, L_d=0.036, L_q=0.051, psi_f=0.545)
    plant = model.Drive(
        model.SynchronousMachine(parameters),
        model.MechanicalSystem(J=0.015),
        model.VoltageSourceConverter(u_dc=540, t_d=dead_time),
        pwm=True,
    )
    vector = control.FluxVectorController(
        parameters, control.FluxVectorControllerCfg(i_s_max=9.0, sensorless=False)
    )
    system = control.VectorControlSystem(vector, control.SpeedController(J=0.015, alpha_s=25))
    return plant, system


def simulated(dead_time=0.0):
    """Simulate a drive of a dead time (s); return the processor time, and the speed at the end."""
    from motulator.drive import model

    plant, system = drive(dead_time)
    system.set_speed_ref(lambda t: SPEED)
    plant.mechanics.set_external_load_torque(lambda t: LOAD_NM * (t > LOAD_STEP_S))
    simulation = model.Simulation(plant, system, show_progress=False)
    began = time.process_time()
    results = simulation.simulate(t_stop=SIMULATED_S)
    return time.process_time() - began, float(results.mdl.mechanics.w_M[-1])


def main():
    """Measure and print."""
    try:
        installed = version("motulator")
    except PackageNotFoundError:
        sys.stderr.write("motulator is not installed in this Python: not measured\n")
        return
    seconds, speed = simulated()
    row = {
        "peer": "motulator",
        "version": installed,
        "job": "3 phases, carrier PWM, adaptive solver",
        "times_real_time": SIMULATED_S / seconds,
        "valid": abs(speed - SPEED) < 1.0,
        "check": f"ends at {speed:.2f} of {SPEED:.2f} rad/s",
    }
    sys.stdout.write(json.dumps(row, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
