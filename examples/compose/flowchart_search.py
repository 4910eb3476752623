"""The search of the paper's Fig. 4, to the letter, to take the place of the reference's."""

from math import inf, pi, radians

from drivegate import Nameplate, Sense


class Search:
    """Moves the advance angle away from its initial value, one degree at a time, toward less input power."""

    def reset(self, nameplate: Nameplate) -> None:
        """Prepare for a run: called before every one, and must forget everything."""
        self.steps_per_decision = round(0.1 / nameplate.control_period)
        self.offset = 0.0
        self.direction = -1.0
        self.old_power = inf
        self.power_sum = 0.0
        self.count = 0

    def step(self, sense: Sense, current_reference: float) -> float:
        """Answer with what is to be added to the initial angle (rad); called at each step above base speed."""
        self.power_sum += sense.current_magnitude_sum
        self.count += 1
        if self.count == self.steps_per_decision:
            self.decide(self.power_sum / self.count, abs(sense.speed_reference - sense.speed))
            self.power_sum = 0.0
            self.count = 0
        return self.offset

    def decide(self, power: float, speed_error: float) -> None:
        """Make one decision of the flowchart; the sum of the currents stands for the power."""
        if speed_error > 5.0 * pi / 30.0:
            return
        change = power - self.old_power
        self.old_power = power
        if abs(change) <= 0.001 * power:
            return
        if change > 0.0:
            self.direction = -self.direction
        self.offset += self.direction * radians(1.0)
