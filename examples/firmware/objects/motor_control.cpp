#include "motor_control.hpp"

namespace motor_control {

static constexpr double bandwidth = 0.2;       // of the current regulators, times the control period
static constexpr double speed_share = 0.02;    // of the speed regulator, over that
static constexpr double voltage_share = 0.985; // of the linear range; the current regulators need the rest
static constexpr double braking_share = 0.185; // of it for regulation while the speed regulator brakes

static PiRegulator current_regulator(double inductance, double resistance, double period) {
    double gain = bandwidth / period * inductance;
    return {gain, bandwidth * std::max(resistance, 0.1 * gain)};
}

static PiRegulator speed_regulator_of(double inertia, double period) {
    double gain = inertia * speed_share * bandwidth / period;
    return {gain, 0.25 * speed_share * bandwidth * gain};
}

Controller::Controller(const Motor &motor, const Limits &limits)
    : motor{motor}, limits{limits}, references{motor, limits},
      direct_regulator{current_regulator(motor.direct_inductance, motor.resistance, limits.period)},
      quadrature_regulator{current_regulator(motor.quadrature_inductance, motor.resistance, limits.period)},
      speed_regulator{speed_regulator_of(motor.inertia, limits.period)} {}

std::array<double, 3> Controller::step(
    const double *currents, double measured_link, double angle, double speed, double demand, bool is_torque) {
    const double link = std::max(measured_link, 1.0); // a sensor may show 0
    const double electrical = motor.pole_pairs * speed, limit = link / root_three, error = demand - speed;
    const Vector current = Park{motor.pole_pairs * angle}.of_phases(currents);

    const double torque = is_torque ? demand : speed_regulator.output(error);
    double allowed = voltage_share * limit;
    if (!is_torque && torque * speed < 0.0)
        allowed -= braking_share * limit * std::min(1.0, std::abs(torque) / (0.2 * references.most_torque));
    const double direct = references.direct_for(torque, electrical, allowed, weakening);
    const double possible = std::max(references.greatest_torque(direct, std::abs(electrical), allowed), 0.0);
    // The speed integral waits while the limits leave less than it demands.
    if (!is_torque && std::abs(torque) > possible && torque * error > 0.0) speed_regulator.undo();
    const double quadrature = std::clamp(torque, -possible, possible) / motor.torque_per_ampere(direct);

    Vector voltage{
        direct_regulator.output(direct - current.direct) - electrical * motor.quadrature_inductance * current.quadrature,
        quadrature_regulator.output(quadrature - current.quadrature)
            + electrical * (motor.direct_inductance * current.direct + motor.magnet_flux)};
    const double length = std::hypot(voltage.direct, voltage.quadrature);
    const double excess = 1.0 - std::min(1.0, limit / std::max(length, 1e-6));
    direct_regulator.lost(excess * voltage.direct);
    quadrature_regulator.lost(excess * voltage.quadrature);
    voltage = {voltage.direct - excess * voltage.direct, voltage.quadrature - excess * voltage.quadrature};
    weakening += 0.1 * bandwidth * limits.current / limits.voltage * (0.5 * (1.0 + voltage_share) * limit - length);
    weakening = std::clamp(weakening, -0.3 * limits.current, 0.0);

    // The voltage acts later; the rotor turns on meanwhile.
    const Park later{motor.pole_pairs * angle + electrical * limits.delay};
    return SpaceVectorModulation::duty_ratios(later.to_phases(voltage), link);
}

} // namespace motor_control
