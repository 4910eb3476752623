"""A speed regulator with proportional and integral part, to take the place of the reference's."""

from drivegate import Nameplate


class Regulator:
    """Limits its output to what the drive can take, and stops integrating while it is limited."""

    def reset(self, nameplate: Nameplate) -> None:
        """Prepare for a run: called before every one, and must forget everything."""
        # The torque that one ampere of reference gives.
        torque_per_ampere = nameplate.conducting_phases * nameplate.emf_constant
        # The speed follows with 80 rad/s, and the integral catches up with 15 rad/s, on a drive whose electrical
        # frequency at base speed is 576 rad/s; on others in proportion.
        rate = nameplate.pole_pairs * nameplate.base_speed / 575.9586531581288
        self.proportional = nameplate.inertia * (80.0 * rate) / torque_per_ampere
        self.integral_step = self.proportional * (15.0 * rate) * nameplate.control_period
        self.limit = nameplate.current_limit
        # The reference's search sets this back when an angle has cost it the speed.
        self.integral = 0.0

    def step(self, speed_reference: float, speed: float, dt: float) -> float:
        """Answer with the current reference (A); speeds are in rad/s, `dt` is the control period (s)."""
        error = speed_reference - speed
        before = self.integral
        after = min(max(before + self.integral_step * error, 0.0), self.limit)
        reference = self.proportional * error + after
        self.integral = after
        if reference > self.limit:
            self.integral = min(before, after) if error > 0.0 else after
            return self.limit
        if reference < 0.0:
            self.integral = max(before, after) if error < 0.0 else after
            return 0.0
        return reference
