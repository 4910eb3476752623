"""Field-oriented control: speed, least current, weakening, currents with decoupling, and a min-max zero sequence."""

from math import cos, hypot, radians, sin, sqrt

from drivegate import TORQUE_REFERENCE, DutyCommand, DutyNameplate, DutySense

ROOT_THREE = sqrt(3.0)
# Bandwidth of the currents over the sampling rate, which a delay of one and a half periods bears, that of the speed
# over it, and that of their integrals.
CURRENT_SHARE, SPEED_SHARE, INTEGRAL_SHARE = 0.2, 0.02, 0.1
# Of the undistorted voltage, what references are made for, the rest being for the current regulators; and what is left
# of it where a speed is braked to, for a machine of less inductance than on the nameplate.
VOLTAGE_SHARE, BRAKING_SHARE = 0.985, 0.185


class Controller:
    """One instance serves one drive; drivegate makes it without arguments."""

    def reset(self, nameplate: DutyNameplate) -> None:
        """Prepare for a run: called before every one, and must forget everything."""
        period = nameplate.control_period
        bandwidth = CURRENT_SHARE / period
        self.regulates_torque = nameplate.reference_kind == TORQUE_REFERENCE
        self.pole_pairs = nameplate.pole_pairs
        self.resistance = nameplate.resistance
        self.direct_inductance = nameplate.direct_inductance
        self.quadrature_inductance = nameplate.quadrature_inductance
        self.saliency = nameplate.quadrature_inductance - nameplate.direct_inductance
        self.flux = nameplate.magnet_flux
        self.limit = nameplate.current_limit
        # Beyond the magnet's whole flux the voltage rises again.
        self.deepest = -min(0.999 * self.limit, self.flux / self.direct_inductance)
        self.greatest = max(self.torque_at(degree) for degree in range(90))
        # From the sample to the middle of the period in which the answer acts (s).
        self.lead = (nameplate.update_delay + 0.5) * period
        self.direct_gain = bandwidth * nameplate.direct_inductance
        self.quadrature_gain = bandwidth * nameplate.quadrature_inductance
        self.direct_step = CURRENT_SHARE * max(self.resistance, INTEGRAL_SHARE * self.direct_gain)
        self.quadrature_step = CURRENT_SHARE * max(self.resistance, INTEGRAL_SHARE * self.quadrature_gain)
        self.speed_gain = nameplate.inertia * SPEED_SHARE * bandwidth
        self.speed_step = self.speed_gain * 0.25 * SPEED_SHARE * CURRENT_SHARE
        self.weakening_step = 0.02 * CURRENT_SHARE
        self.weakening_step /= self.pole_pairs * nameplate.base_speed * self.direct_inductance
        self.speed_integral = self.direct_integral = self.quadrature_integral = self.weakening = 0.0

    def step(self, sense: DutySense) -> DutyCommand:
        """Answer for one control period; all quantities are in SI units."""
        electrical = self.pole_pairs * sense.speed
        angle = self.pole_pairs * sense.angle
        if not sense.enable:
            self.preload(sense, electrical, angle)
            return DutyCommand(duty_ratios=(0.5, 0.5, 0.5))
        supply = max(sense.supply_voltage, 1e-9)
        limit = supply / ROOT_THREE
        direct, quadrature = rotor_components(sense.phase_currents, angle)
        direct_reference, quadrature_reference = self.references(
            sense.reference, sense.speed, abs(electrical), VOLTAGE_SHARE * limit
        )
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
        # A voltage beyond the limit is shortened, not turned: one axis alone would never get the other back.
        share = limit / max(limit, hypot(direct_wanted, quadrature_wanted))
        direct_given, quadrature_given = share * direct_wanted, share * quadrature_wanted
        # What the limit has taken does not enter the integrals.
        self.direct_integral += self.direct_step * (
            direct_error + (direct_given - direct_wanted) / self.direct_gain
        )
        self.quadrature_integral += self.quadrature_step * (
            quadrature_error + (quadrature_given - quadrature_wanted) / self.quadrature_gain
        )
        # Where the machine is not as on the nameplate, the voltage that is asked for shows.
        self.weakening += self.weakening_step * (
            0.5 * (1.0 + VOLTAGE_SHARE) * limit - hypot(direct_wanted, quadrature_wanted)
        )
        self.weakening = min(max(self.weakening, -0.3 * self.limit), 0.0)

        ahead = angle + electrical * self.lead
        along = cos(ahead) * direct_given - sin(ahead) * quadrature_given
        across = sin(ahead) * direct_given + cos(ahead) * quadrature_given
        torque = self.per_ampere(direct) * quadrature
        return DutyCommand(duty_ratios=duty_ratios(along, across, supply), torque=torque)

    def preload(self, sense: DutySense, electrical: float, angle: float) -> None:
        """Let the integrals begin at what the back-EMF adds to the nominal one, while the bridge is off."""
        # Terminals at the rail of a conducting diode do not show it.
        if max(sense.phase_voltages) < sense.supply_voltage:
            self.direct_integral, induced = rotor_components(sense.phase_voltages, angle)
            self.quadrature_integral = induced - electrical * self.flux

    def references(
        self, reference: float, speed: float, electrical: float, voltage: float
    ) -> tuple[float, float]:
        """Return the currents for what is asked for, as far as the limits allow (A)."""
        error, torque = reference - speed, reference
        if not self.regulates_torque:
            self.speed_integral += self.speed_step * error
            torque = self.speed_gain * error + self.speed_integral
            if torque * speed < 0.0:
                hard = min(abs(torque) / (0.2 * self.greatest), 1.0)
                voltage *= 1.0 - hard * BRAKING_SHARE / VOLTAGE_SHARE
        direct = self.direct_for(min(abs(torque), self.greatest), electrical, voltage) + self.weakening
        direct = max(direct, self.deepest)
        possible = max(self.possible(direct, electrical, voltage), 0.0)
        # The integral of the speed waits while the limits leave less than it asks for.
        if not self.regulates_torque and abs(torque) > possible and torque * error > 0.0:
            self.speed_integral -= self.speed_step * error
        quadrature = between(torque, possible) / self.per_ampere(direct)
        return direct, between(quadrature, sqrt(self.limit * self.limit - direct * direct))

    def direct_for(self, torque: float, electrical: float, voltage: float) -> float:
        """Return the direct current for a torque, at least 0 (A).

        It is that of least magnitude, weakened as far as the voltage asks for, or that of the greatest torque where
        the limits leave less.
        """
        start = chosen = last = self.least_current(torque)
        greatest = self.possible(start, electrical, voltage)
        if greatest >= torque:
            return start
        for step in range(1, 65):
            direct = start + (self.deepest - start) * step / 64
            possible = self.possible(direct, electrical, voltage)
            if possible >= torque:
                for _ in range(8):
                    middle = 0.5 * (last + direct)
                    if self.possible(middle, electrical, voltage) >= torque:
                        direct = middle
                    else:
                        last = middle
                return direct
            if possible > greatest:
                greatest, chosen = possible, direct
            last = direct
        return chosen

    def possible(self, direct: float, electrical: float, voltage: float) -> float:
        """Return the greatest torque at a direct current within the limits (N·m); negative where there is none."""
        room = self.limit * self.limit - direct * direct
        along = electrical * (self.direct_inductance * direct + self.flux)
        reactance, resistance = electrical * self.quadrature_inductance, self.resistance
        # The voltage is a quadratic in the quadrature current: a q² + 2 b q + c = 0 at its limit.
        a = reactance * reactance + resistance * resistance
        b = resistance * (along - reactance * direct)
        c = resistance * resistance * direct * direct + along * along - voltage * voltage
        inside = b * b - a * c
        if room < 0.0 or inside < 0.0:
            return -1.0
        quadrature = sqrt(room)
        if a > 0.0:
            quadrature = min(quadrature, (sqrt(inside) - b) / a)
        return self.per_ampere(direct) * quadrature

    def least_current(self, torque: float) -> float:
        """Return the direct current with which a torque takes least current (A)."""
        direct = 0.0
        if self.saliency < 1e-3 * self.direct_inductance:
            return direct
        for _ in range(6):
            lifted = hypot(self.flux, 2.0 * self.saliency * torque / self.per_ampere(direct))
            direct = (self.flux - lifted) / (2.0 * self.saliency)
        return direct

    def per_ampere(self, direct: float) -> float:
        """Return the torque of an ampere across the magnet's axis (N·m/A)."""
        return 1.5 * self.pole_pairs * (self.flux - self.saliency * direct)

    def torque_at(self, degree: int) -> float:
        """Return the torque at the current limit, by the angle of the current (N·m)."""
        ahead = radians(degree)
        return self.per_ampere(-self.limit * sin(ahead)) * self.limit * cos(ahead)


def between(value: float, bound: float) -> float:
    """Keep a value within a bound on either side."""
    return min(max(value, -bound), bound)


def rotor_components(phases: tuple[float, float, float], angle: float) -> tuple[float, float]:
    """Return currents (A) or voltages (V) of the phases along and across the magnet's axis."""
    first, second, third = phases
    along, across = (2.0 * first - second - third) / 3.0, (second - third) / ROOT_THREE
    return cos(angle) * along + sin(angle) * across, cos(angle) * across - sin(angle) * along


def duty_ratios(along: float, across: float, supply: float) -> tuple[float, float, float]:
    """Return the duty ratios of a voltage in the frame that stands still, about the middle of the link."""
    second = -0.5 * along + 0.5 * ROOT_THREE * across
    third = -0.5 * along - 0.5 * ROOT_THREE * across
    middle = 0.5 * (max(along, second, third) + min(along, second, third))
    first, second, third = (
        min(max(0.5 + (phase - middle) / supply, 0.0), 1.0) for phase in (along, second, third)
    )
    return first, second, third
