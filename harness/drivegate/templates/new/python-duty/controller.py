"""Field-oriented control.

A speed regulator, the least current for a torque, field weakening, current regulators with decoupling and anti-windup,
and min-max modulation. Every constant follows from the nameplate; all quantities are in SI units.
"""

from math import cos, sin, sqrt

from drivegate import TORQUE_REFERENCE, DutyCommand, DutyNameplate, DutySense

ROOT_THREE = 1.7320508075688772
# Bandwidth of the currents over the sampling rate, of the speed over that, and of the currents' integrals over that.
CURRENT_SHARE, SPEED_SHARE, INTEGRAL_SHARE = 0.2, 0.02, 0.1
# Share of the voltage limit that references use; the rest is for the current regulators. Braking from a speed to a
# lower one leaves more, for a machine of less inductance than on the nameplate.
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
        self.saliency = self.quadrature_inductance - self.direct_inductance
        self.flux = nameplate.magnet_flux
        self.limit = nameplate.current_limit
        # Beyond the magnet's whole flux the voltage rises again.
        self.deepest = -min(0.999 * self.limit, self.flux / self.direct_inductance)
        # The torque at the current limit, with the direct current that makes it the greatest.
        turned = 2.0 * self.saliency * self.limit
        direct = -turned * self.limit / (self.flux + sqrt(self.flux * self.flux + 2.0 * turned * turned))
        self.greatest = self.per_ampere(direct) * sqrt(self.limit * self.limit - direct * direct)
        # From the sample to the middle of the period in which the answer acts (s).
        self.lead = (nameplate.update_delay + 0.5) * period
        self.direct_gain = bandwidth * self.direct_inductance
        self.quadrature_gain = bandwidth * self.quadrature_inductance
        self.direct_step = CURRENT_SHARE * max(self.resistance, INTEGRAL_SHARE * self.direct_gain)
        self.quadrature_step = CURRENT_SHARE * max(self.resistance, INTEGRAL_SHARE * self.quadrature_gain)
        self.speed_gain = nameplate.inertia * SPEED_SHARE * bandwidth
        self.speed_step = self.speed_gain * 0.25 * SPEED_SHARE * CURRENT_SHARE
        base_speed = self.pole_pairs * nameplate.base_speed
        self.weakening_step = 0.02 * CURRENT_SHARE / (base_speed * self.direct_inductance)
        self.speed_integral = self.direct_integral = self.quadrature_integral = self.weakening = 0.0

    def step(self, sense: DutySense) -> DutyCommand:
        """Answer for one control period."""
        electrical, angle = self.pole_pairs * sense.speed, self.pole_pairs * sense.angle
        supply = max(sense.supply_voltage, 1e-9)
        limit = supply / ROOT_THREE
        if not sense.enable:
            self.preload(sense.phase_voltages, angle, electrical, supply)
            return DutyCommand(duty_ratios=(0.5, 0.5, 0.5))
        direct, quadrature = park(sense.phase_currents, angle)
        wanted = self.references(sense.reference, sense.speed, electrical, limit)
        error = wanted[0] - direct, wanted[1] - quadrature
        voltage = self.regulate(error, (direct, quadrature), electrical, limit)
        ratios = modulate(voltage, angle + electrical * self.lead, supply)
        return DutyCommand(duty_ratios=ratios, torque=self.per_ampere(direct) * quadrature)

    def preload(
        self, terminals: tuple[float, float, float], angle: float, electrical: float, supply: float
    ) -> None:
        """Let the integrals begin at what the back-EMF adds to the nominal one, while the bridge is off."""
        # Terminals at the rail of a conducting diode do not show it.
        if max(terminals) < supply:
            self.direct_integral, induced = park(terminals, angle)
            self.quadrature_integral = induced - electrical * self.flux

    def regulate(
        self, error: tuple[float, float], current: tuple[float, float], electrical: float, limit: float
    ) -> tuple[float, float]:
        """Return the voltage that brings the currents to their references (V), within the limit."""
        # The coupling of the axes and the back-EMF are added in advance.
        direct = (
            self.direct_gain * error[0]
            + self.direct_integral
            - electrical * self.quadrature_inductance * current[1]
        )
        quadrature = (
            self.quadrature_gain * error[1]
            + self.quadrature_integral
            + electrical * (self.direct_inductance * current[0] + self.flux)
        )
        # A voltage beyond the limit is shortened, not turned. What the limit cuts does not enter the integrals.
        used = magnitude(direct, quadrature)
        share = limit / max(limit, used)
        cut = share - 1.0
        self.direct_integral += self.direct_step * (error[0] + cut * direct / self.direct_gain)
        self.quadrature_integral += self.quadrature_step * (
            error[1] + cut * quadrature / self.quadrature_gain
        )
        # A machine that differs from the nameplate shows in the voltage that is requested.
        weakening = self.weakening + self.weakening_step * (0.5 * (1.0 + VOLTAGE_SHARE) * limit - used)
        self.weakening = between(weakening, -0.3 * self.limit, 0.0)
        return share * direct, share * quadrature

    def references(
        self, reference: float, speed: float, electrical: float, limit: float
    ) -> tuple[float, float]:
        """Return the currents for what the reference requests, as far as the limits allow (A)."""
        error = reference - speed
        integral = self.speed_integral + self.speed_step * error
        torque = reference if self.regulates_torque else self.speed_gain * error + integral
        # Negative where the torque brakes: the drop of the resistance is then against the back-EMF.
        turning = -electrical if torque < 0.0 else electrical
        voltage = VOLTAGE_SHARE * limit
        if not self.regulates_torque and turning < 0.0:
            voltage -= BRAKING_SHARE * limit * min(abs(torque) / (0.2 * self.greatest), 1.0)
        direct = self.direct_for(min(abs(torque), self.greatest), turning, voltage)
        direct = max(direct + self.weakening, self.deepest)
        most = max(self.possible(direct, turning, voltage), 0.0)
        # The integral of the speed waits while the limits allow less than it requests.
        if abs(torque) <= most or torque * error <= 0.0:
            self.speed_integral = integral
        return direct, between(torque, -most, most) / self.per_ampere(direct)

    def direct_for(self, torque: float, electrical: float, voltage: float) -> float:
        """Return the direct current (A) for a torque: the least, weakened for the voltage, or that of most torque."""
        direct, deeper, near = self.least_current(torque), self.deepest, 0.001 * self.limit
        if self.possible(direct, electrical, voltage) >= torque:
            return direct
        for _ in range(14):
            middle = 0.5 * (direct + deeper)
            found = self.possible(middle, electrical, voltage)
            if found >= torque or self.possible(middle - near, electrical, voltage) <= found:
                deeper = middle
            else:
                direct = middle
        return deeper

    def possible(self, direct: float, electrical: float, voltage: float) -> float:
        """Return the greatest torque at a direct current within both limits (N·m), negative if there is none."""
        headroom = self.limit * self.limit - direct * direct
        along = electrical * (self.direct_inductance * direct + self.flux)
        reactance, resistance = electrical * self.quadrature_inductance, self.resistance
        # The voltage is a quadratic in the quadrature current: a q² + 2 b q + c = 0 at its limit.
        a = reactance * reactance + resistance * resistance
        b = resistance * (along - reactance * direct)
        c = resistance * resistance * direct * direct + along * along - voltage * voltage
        inside = b * b - a * c
        if inside < 0.0:
            return inside
        return self.per_ampere(direct) * min(sqrt(headroom), (sqrt(inside) - b) / a)

    def least_current(self, torque: float) -> float:
        """Return the direct current with which a torque needs the least current (A)."""
        direct = 0.0
        for _ in range(6):
            quadrature = torque / self.per_ampere(direct)
            turned = 2.0 * self.saliency * quadrature
            direct = -turned * quadrature / (self.flux + magnitude(self.flux, turned))
        return direct

    def per_ampere(self, direct: float) -> float:
        """Return the torque of one ampere across the magnet's axis (N·m/A)."""
        return 1.5 * self.pole_pairs * (self.flux - self.saliency * direct)


def between(value: float, least: float, greatest: float) -> float:
    """Return a value within bounds."""
    return min(max(value, least), greatest)


def magnitude(along: float, across: float) -> float:
    """Return the length of a vector."""
    return sqrt(along * along + across * across)


def park(phases: tuple[float, float, float], angle: float) -> tuple[float, float]:
    """Transform currents (A) or voltages (V) of the phases into the frame of the rotor, by Clarke and Park."""
    first, second, third = phases
    along, across = (2.0 * first - second - third) / 3.0, (second - third) / ROOT_THREE
    return cos(angle) * along + sin(angle) * across, cos(angle) * across - sin(angle) * along


def modulate(voltage: tuple[float, float], angle: float, supply: float) -> tuple[float, float, float]:
    """Return the duty ratios for a voltage (V), by inverse Park and Clarke, centred in the link by a zero sequence."""
    along = cos(angle) * voltage[0] - sin(angle) * voltage[1]
    across = 0.5 * ROOT_THREE * (sin(angle) * voltage[0] + cos(angle) * voltage[1])
    phases = along, across - 0.5 * along, -across - 0.5 * along
    middle = 0.5 * (max(phases) + min(phases))
    first, second, third = (between(0.5 + (phase - middle) / supply, 0.0, 1.0) for phase in phases)
    return first, second, third
