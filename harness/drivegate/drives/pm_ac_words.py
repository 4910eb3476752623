"""What a PM AC drive can do, and what is required of its controllers, in sentences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drivegate.contracts.duty.numbers import numbers as duty_numbers
from drivegate_cases.drive.pm_ac.document import PmAcDocument


def pm_ac_facts(document: Mapping[str, Any]) -> tuple[str, ...]:
    """Tell where the voltage is used up, how far rated power reaches, and the times."""
    limit, magnet = document["rating"]["current_limit_a"], document["magnet_current_a"]
    end = document["rated_power_up_to_rpm"]
    reach = "without end" if end is None else f"up to {end:.5g} rpm"
    return (
        f"the current limit uses up the undistorted {document['undistorted_voltage_v']:.4g} V of a phase at "
        f"{document['voltage_used_up_at_rpm']:.5g} rpm; six steps would give {document['six_step_voltage_v']:.4g} V",
        f"the magnet's flux is worth {magnet:.4g} A along its axis, "
        + (
            f"within the limit of {limit:g} A: the speed range is unbounded"
            if magnet <= limit
            else f"above the limit of {limit:g} A"
        )
        + f"; rated power is there {reach}",
        f"a step every {1e6 * document['control_period_s']:.4g} µs; a steady state is judged "
        f"{document['settling_s']:g} s after a change",
    )


def pm_ac_required(drive: PmAcDocument) -> str:
    """Tell what is required of the controllers of a drive, in its own numbers."""
    return (
        "required: speed within {k1} (k1) or torque within {torque_error}, steps with at most {overshoot} of overshoot "
        "and {rise}, in weakening at least {weakening} of the greatest torque with {weakening_voltage} of the voltage, "
        "phase currents up to {peak}"
    ).format_map(duty_numbers(drive))
