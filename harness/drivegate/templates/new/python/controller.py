"""A speed regulator, and an advance angle that rises with speed by a straight line."""

from math import pi

from drivegate import Command, Nameplate, Sense


class Controller:
    """One instance serves one drive; drivegate makes it without arguments."""

    def reset(self, nameplate: Nameplate) -> None:
        """Prepare for a run: called before every one, and must forget everything."""
        # The torque that one ampere gives (N·m/A).
        torque_per_ampere = nameplate.conducting_phases * nameplate.emf_constant
        # The speed follows its reference with 80 rad/s, and the integral with 15 rad/s, on a drive of 576 rad/s
        # electrical at base speed; on others in proportion.
        rate = nameplate.pole_pairs * nameplate.base_speed / 575.9586531581288
        self.proportional = nameplate.inertia * (80.0 * rate) / torque_per_ampere
        self.integral_step = self.proportional * (15.0 * rate) * nameplate.control_period
        self.limit = nameplate.current_limit
        self.base_speed = nameplate.base_speed
        self.advance_start = nameplate.advance_start
        self.advance_slope = nameplate.advance_slope
        self.integral = 0.0

    def step(self, sense: Sense) -> Command:
        """Answer for one control period; all quantities are in SI units."""
        return Command(
            current_reference=self.regulate(sense.speed_reference - sense.speed),
            advance_angle=self.angle(sense.speed),
            # An estimate of the input power; leave it out if the controller makes none.
            input_power=sense.half_supply_voltage * sense.current_magnitude_sum,
        )

    def regulate(self, error: float) -> float:
        """Return the current reference (A); the integral waits while the limits leave nothing to do."""
        integral = self.integral + self.integral_step * error
        reference = self.proportional * error + integral
        limited = min(max(reference, 0.0), self.limit)
        if limited == reference:
            self.integral = integral
        return limited

    def angle(self, speed: float) -> float:
        """Return the advance angle (rad, electrical). Below base speed it must be 0 exactly (check ADV-1)."""
        if speed < self.base_speed:
            return 0.0
        # Your search for the angle of least input power would add its own part here (check CNV-2).
        line = self.advance_start + self.advance_slope * (speed - self.base_speed)
        return min(max(line, 0.0), 0.5 * pi)
