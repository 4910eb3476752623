"""A speed regulator of one's own with the search of controller.py: a candidate of two blocks."""

from controller import Controller

from drivegate import Nameplate


class Regulator:
    """PI regulator of the speed by back-calculation: the integral loses what the limit cuts off."""

    def reset(self, nameplate: Nameplate) -> None:
        """Prepare for a run, and forget all earlier ones."""
        bandwidth = nameplate.pole_pairs * nameplate.base_speed / 7.2
        self.gain = bandwidth * nameplate.inertia / (nameplate.conducting_phases * nameplate.emf_constant)
        self.rate = 0.1875 * bandwidth * nameplate.control_period
        self.limit = nameplate.current_limit
        self.integral = 0.0

    def step(self, error: float) -> float:
        """Return the current reference (A) for a speed error (rad/s)."""
        wanted = self.gain * error + self.integral
        reference = min(max(wanted, 0.0), self.limit)
        self.integral += self.rate * (self.gain * error + reference - wanted)
        return reference


class Combined(Controller):
    """The example's search sets the angle, the regulator above the current."""

    def reset(self, nameplate: Nameplate) -> None:
        """Prepare for a run, and forget all earlier ones."""
        super().reset(nameplate)
        self.regulator = Regulator()
        self.regulator.reset(nameplate)

    def regulate(self, error: float) -> float:
        """Return the current reference; the search may have set the integral back since the last step."""
        self.regulator.integral = self.integral
        reference = self.regulator.step(error)
        self.integral = self.regulator.integral
        return reference
