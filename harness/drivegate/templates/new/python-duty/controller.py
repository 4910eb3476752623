"""Field-oriented control: speed, most torque per ampere, currents with decoupling, and a min-max zero sequence."""

from math import cos, hypot, sin, sqrt

from drivegate import TORQUE_REFERENCE, DutyCommand, DutyNameplate, DutySense

ROOT_THREE = sqrt(3.0)
# Bandwidth of the currents over the sampling rate, which a delay of one and a half periods bears, that of the speed
# over it, and that of their integrals.
CURRENT_SHARE, SPEED_SHARE, INTEGRAL_SHARE = 0.2, 0.02, 0.1


class Controller:
    """One instance serves one drive; drivegate makes it without arguments."""

    def reset(self, nameplate: DutyNameplate) -> None:
        """Prepare for a run: called before every one, and must forget everything."""
        period, resistance = nameplate.control_period, nameplate.resistance
        self.regulates_torque = nameplate.reference_kind == TORQUE_REFERENCE
        self.pole_pairs = nameplate.pole_pairs
        self.direct_inductance = nameplate.direct_inductance
        self.quadrature_inductance = nameplate.quadrature_inductance
        self.saliency = nameplate.quadrature_inductance - nameplate.direct_inductance
        self.flux = nameplate.magnet_flux
        self.limit = nameplate.current_limit
        # From the sample to the middle of the period in which the answer acts (s).
        self.lead = (nameplate.update_delay + 0.5) * period
        bandwidth = CURRENT_SHARE / period
        self.direct_gain = bandwidth * nameplate.direct_inductance
        self.quadrature_gain = bandwidth * nameplate.quadrature_inductance
        self.direct_step = CURRENT_SHARE * max(resistance, INTEGRAL_SHARE * self.direct_gain)
        self.quadrature_step = CURRENT_SHARE * max(resistance, INTEGRAL_SHARE * self.quadrature_gain)
        self.speed_gain = nameplate.inertia * SPEED_SHARE * bandwidth
        self.speed_step = self.speed_gain * 0.25 * SPEED_SHARE * CURRENT_SHARE
        self.greatest_torque = self.torque(*self.for_quadrature(self.limit))
        self.speed_integral = self.direct_integral = self.quadrature_integral = 0.0

    def step(self, sense: DutySense) -> DutyCommand:
        """Answer for one control period; all quantities are in SI units."""
        electrical = self.pole_pairs * sense.speed
        angle = self.pole_pairs * sense.angle
        direct, quadrature = rotor_currents(sense.phase_currents, angle)
        wanted = sense.reference if self.regulates_torque else self.regulate(sense.reference - sense.speed)
        direct_reference, quadrature_reference = self.for_torque(wanted)

        direct_error = direct_reference - direct
        quadrature_error = quadrature_reference - quadrature
        # What each axis is coupled to the other by, and the back-EMF, are added beforehand.
        direct_wanted = (
            self.direct_gain * direct_error
            + self.direct_integral
            - electrical * self.quadrature_inductance * quadrature
        )
        quadrature_wanted = (
            self.quadrature_gain * quadrature_error
            + self.quadrature_integral
            + electrical * (self.direct_inductance * direct + self.flux)
        )
        supply = max(sense.supply_voltage, 1e-9)
        limit = supply / ROOT_THREE
        direct_given = min(max(direct_wanted, -limit), limit)
        room = sqrt(limit * limit - direct_given * direct_given)
        quadrature_given = min(max(quadrature_wanted, -room), room)
        # What the limit has taken does not enter the integrals.
        self.direct_integral += self.direct_step * (
            direct_error + (direct_given - direct_wanted) / self.direct_gain
        )
        self.quadrature_integral += self.quadrature_step * (
            quadrature_error + (quadrature_given - quadrature_wanted) / self.quadrature_gain
        )
        ahead = angle + electrical * self.lead
        along = cos(ahead) * direct_given - sin(ahead) * quadrature_given
        across = sin(ahead) * direct_given + cos(ahead) * quadrature_given
        return DutyCommand(
            duty_ratios=duty_ratios(along, across, supply), torque=self.torque(direct, quadrature)
        )

    def regulate(self, error: float) -> float:
        """Give the torque for an error of speed (N·m); the integral waits while the limit leaves nothing to do."""
        integral = self.speed_integral + self.speed_step * error
        torque = self.speed_gain * error + integral
        if abs(torque) < self.greatest_torque or torque * error < 0.0:
            self.speed_integral = integral
        return min(max(torque, -self.greatest_torque), self.greatest_torque)

    def for_torque(self, torque: float) -> tuple[float, float]:
        """Give the currents of least magnitude for a torque, as far as their limit allows (A)."""
        # Your weakening would add its own part to the direct current here (checks FWK-1 to FWK-3).
        quadrature = torque / (1.5 * self.pole_pairs * self.flux)
        for _ in range(6):
            direct, quadrature = self.for_quadrature(quadrature)
            quadrature = torque / (1.5 * self.pole_pairs * (self.flux - self.saliency * direct))
        magnitude = hypot(direct, quadrature)
        share = min(1.0, self.limit / magnitude) if magnitude > 0.0 else 1.0
        return share * direct, share * quadrature

    def for_quadrature(self, quadrature: float) -> tuple[float, float]:
        """Give the direct current with which a quadrature current makes most torque per ampere, and that one (A)."""
        if self.saliency < 1e-3 * self.direct_inductance:
            return 0.0, quadrature
        lifted = hypot(self.flux, 2.0 * self.saliency * quadrature)
        return (self.flux - lifted) / (2.0 * self.saliency), quadrature

    def torque(self, direct: float, quadrature: float) -> float:
        """Give the torque of currents (N·m)."""
        return 1.5 * self.pole_pairs * (self.flux - self.saliency * direct) * quadrature


def rotor_currents(currents: tuple[float, float, float], angle: float) -> tuple[float, float]:
    """Give the currents along and across the magnet's axis (A)."""
    first, second, third = currents
    along, across = (2.0 * first - second - third) / 3.0, (second - third) / ROOT_THREE
    return cos(angle) * along + sin(angle) * across, cos(angle) * across - sin(angle) * along


def duty_ratios(along: float, across: float, supply: float) -> tuple[float, float, float]:
    """Give the duty ratios of a voltage in the frame that stands still, about the middle of the link."""
    second = -0.5 * along + 0.5 * ROOT_THREE * across
    third = -0.5 * along - 0.5 * ROOT_THREE * across
    middle = 0.5 * (max(along, second, third) + min(along, second, third))
    first, second, third = (
        min(max(0.5 + (phase - middle) / supply, 0.0), 1.0) for phase in (along, second, third)
    )
    return first, second, third
