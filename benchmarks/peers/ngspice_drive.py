"""The rate of ngspice: this very five-phase drive as a circuit, at fixed speed, angle and current reference.

Run it with the Python that drivegate is installed in; ngspice is a program of its own. It prints one JSON object. The
plant is drivegate's, with switches of 1 mΩ and diodes of almost no drop, and steps of at most 1 µs; there is no speed
loop and no ledger. The mean sum of currents is compared with drivegate's steady state at the same point.
"""

import json
import math
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SPEED_RPM = 1500.0
ADVANCE_DEG = 52.0
REFERENCE_A = 11.0
SIMULATED_S = 0.02
SETTLED_S = 0.01
TOLERANCE = 0.02


def netlist(drive):
    """Write the drive as a circuit; `drive` has SI units."""
    speed = SPEED_RPM * math.pi / 30.0
    electrical = drive.machine.pole_pairs * speed
    advance = math.radians(ADVANCE_DEG)
    flat = math.radians(drive.machine.emf_flat_deg)
    peak = drive.machine.emf_constant_v_s_per_rad * speed
    edge = math.cos(0.5 * math.radians(drive.inverter.window_deg))
    band = drive.inverter.hysteresis_band_a
    lines = [
        "* five phases on a split supply",
        f"vu up 0 {drive.inverter.supply_voltage_v}",
        f"vl 0 low {drive.inverter.supply_voltage_v}",
        f".model gate sw(vt=0 vh={band} ron=1m roff=1meg)",
        ".model freewheel d(is=1e-9 n=0.02 rs=1m)",
    ]
    currents = []
    for phase in range(drive.machine.phases):
        angle = f"({electrical!r}*time-{phase * math.pi / drive.machine.phases!r})"
        wave = f"asin(0.999999999*sin({angle}))*{2.0 / (math.pi - flat)!r}"
        window = f"sin({angle}+{advance!r})"
        current = f"i(vm{phase})"
        currents.append(f"abs({current})")
        lines += [
            f"bu{phase} gu{phase} 0 v=({window} > {edge!r}) ? ({REFERENCE_A}-{current}) : -100",
            f"bl{phase} gl{phase} 0 v=({window} < {-edge!r}) ? ({REFERENCE_A}+{current}) : -100",
            f"su{phase} up n{phase} gu{phase} 0 gate off",
            f"sl{phase} n{phase} low gl{phase} 0 gate off",
            f"du{phase} n{phase} up freewheel",
            f"dl{phase} low n{phase} freewheel",
            f"vm{phase} n{phase} w{phase} 0",
            f"l{phase} w{phase} x{phase} {drive.machine.inductance_h} ic=0",
            f"r{phase} x{phase} y{phase} {drive.machine.resistance_ohm}",
            f"be{phase} y{phase} 0 v={peak!r}*max(-1, min(1, {wave}))",
        ]
    lines += [
        f"bs sum 0 v={'+'.join(currents)}",
        f".tran 1u {SIMULATED_S} 0 1u uic",
        f".meas tran total avg v(sum) from={SETTLED_S} to={SIMULATED_S}",
        ".end",
    ]
    return "\n".join(lines) + "\n"


def main():
    """Measure and print."""
    program = shutil.which("ngspice")
    if program is None:
        sys.stderr.write("ngspice is not installed: not measured\n")
        return
    from drivegate.drives.kinds import DEFAULT_DRIVE
    from drivegate_cases.drive.drive_document import load_drive
    from drivegate_models.half_bridge.plant.phases import make_phases
    from drivegate_models.steady.steady_state import KEPT_TIME, solve_steady_state

    document = load_drive(DEFAULT_DRIVE)
    drive = document.plant()
    state = solve_steady_state(
        drive,
        make_phases(drive, KEPT_TIME),
        make_phases(drive),
        SPEED_RPM * math.pi / 30.0,
        drive.half_supply_voltage,
        REFERENCE_A,
        math.radians(ADVANCE_DEG),
    )
    with tempfile.TemporaryDirectory() as folder:
        circuit = Path(folder) / "drive.cir"
        circuit.write_text(netlist(document))
        began = time.perf_counter()
        ended = subprocess.run(
            [program, "-b", circuit], capture_output=True, text=True, timeout=600, check=False
        )
        seconds = time.perf_counter() - began
    found = re.search(r"^total\s*=\s*(\S+)", ended.stdout, re.MULTILINE)
    measured = float(found[1]) if found else math.nan
    release = subprocess.run([program, "--version"], capture_output=True, text=True, check=False).stdout
    number = re.search(r"ngspice-(\S+)", release)
    row = {
        "peer": "ngspice",
        "version": number[1] if number else "unknown",
        "job": "this drive, fixed speed and reference, 1 µs",
        "times_real_time": SIMULATED_S / seconds,
        "valid": abs(measured - state.current_sum) <= TOLERANCE * state.current_sum,
        "check": f"sum of currents {measured:.2f} A, drivegate {state.current_sum:.2f} A",
    }
    sys.stdout.write(json.dumps(row, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
