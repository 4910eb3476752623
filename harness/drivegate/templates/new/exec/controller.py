"""A controller as a program of its own: one JSON object a line on standard input, one back on standard output.

A proportional-integral speed regulator, and an advance angle that rises with speed by a straight line. It needs
nothing but Python's standard library, and shows what a program in any other language has to do.
"""

import json
import sys
from math import pi


class Controller:
    """The algorithm, which knows nothing of the protocol."""

    def reset(self, nameplate):
        """Forget everything, and choose the constants for the drive at hand."""
        torque_per_ampere = nameplate["conducting_phases"] * nameplate["emf_constant"]
        # 80 rad/s, and 15 rad/s for the integral, on a drive of 576 rad/s electrical at base speed; else in proportion.
        rate = nameplate["pole_pairs"] * nameplate["base_speed"] / 575.9586531581288
        self.proportional = nameplate["inertia"] * (80.0 * rate) / torque_per_ampere
        self.integral_step = self.proportional * (15.0 * rate) * nameplate["control_period"]
        self.limit = nameplate["current_limit"]
        self.base_speed = nameplate["base_speed"]
        self.advance_start = nameplate["advance_start"]
        self.advance_slope = nameplate["advance_slope"]
        self.integral = 0.0

    def step(self, sense):
        """Answer for one control period."""
        return {
            "current_reference": self.current_reference(sense["speed_reference"] - sense["speed"]),
            "advance_angle": self.advance_angle(sense["speed"]),
            "input_power": sense["half_supply_voltage"] * sense["current_magnitude_sum"],
        }

    def current_reference(self, error):
        """Regulate the speed; the integral waits while the limits leave nothing to do."""
        integral = self.integral + self.integral_step * error
        reference = self.proportional * error + integral
        limited = min(max(reference, 0.0), self.limit)
        if limited == reference:
            self.integral = integral
        return limited

    def advance_angle(self, speed):
        """Follow a straight line above base speed."""
        if speed < self.base_speed:
            return 0.0
        line = self.advance_start + self.advance_slope * (speed - self.base_speed)
        return min(max(line, 0.0), 0.5 * pi)


def serve():
    """Answer every line, until there are no more."""
    controller = Controller()
    for line in sys.stdin:
        message = json.loads(line)
        if "sense" in message:
            answer = controller.step(message["sense"])
        elif "reset" in message:
            controller.reset(message["reset"])
            answer = {"ready": True}
        else:
            answer = {"drivegate": 1, "name": "line of angles"}
        print(json.dumps(answer), flush=True)


serve()
