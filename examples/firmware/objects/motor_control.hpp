// A small class library for field-oriented control.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace motor_control {

inline constexpr double root_three = 1.7320508075688772;

struct Motor {
    double pole_pairs, resistance, direct_inductance, quadrature_inductance, magnet_flux, inertia;

    double torque_per_ampere(double direct) const {
        return 1.5 * pole_pairs * (magnet_flux - (quadrature_inductance - direct_inductance) * direct);
    }
};

struct Limits {
    double current, voltage, period, delay; // delay: from sampling to the middle of the pulse
};

struct Vector {
    double direct, quadrature;
};

// The frame of the rotor at one angle.
class Park {
public:
    explicit Park(double angle) : cosine{std::cos(angle)}, sine{std::sin(angle)} {}

    Vector of_phases(const double *phases) const {
        double alpha = (2.0 * phases[0] - phases[1] - phases[2]) / 3.0, beta = (phases[1] - phases[2]) / root_three;
        return {cosine * alpha + sine * beta, cosine * beta - sine * alpha};
    }

    std::array<double, 3> to_phases(Vector vector) const {
        double alpha = cosine * vector.direct - sine * vector.quadrature;
        double beta = sine * vector.direct + cosine * vector.quadrature;
        return {alpha, 0.5 * (root_three * beta - alpha), -0.5 * (root_three * beta + alpha)};
    }

private:
    double cosine, sine;
};

struct SpaceVectorModulation {
    static std::array<double, 3> duty_ratios(std::array<double, 3> phases, double link) {
        auto [lowest, highest] = std::minmax_element(phases.begin(), phases.end());
        double middle = 0.5 * (*lowest + *highest);
        for (double &phase : phases) phase = std::clamp(0.5 + (phase - middle) / link, 0.0, 1.0);
        return phases;
    }
};

class PiRegulator {
public:
    PiRegulator(double gain, double step) : gain{gain}, step{step} {}

    double output(double error) {
        integral += step * error;
        last = error;
        return gain * error + integral;
    }
    void undo() { integral -= step * last; }
    void lost(double output) { integral -= step * output / gain; } // by the limit behind the regulator

private:
    double gain, step, integral = 0.0, last = 0.0;
};

// Currents of a torque: of least magnitude, weakened as far as the voltage requires.
class References {
public:
    References(const Motor &motor, const Limits &limits)
        : motor{motor}, limit{limits.current},
          deepest{-std::min(0.999 * limits.current, motor.magnet_flux / motor.direct_inductance)},
          most_torque{greatest_torque(weakened(0.0, std::numeric_limits<double>::max(), 0.0, limits.voltage), 0.0, limits.voltage)} {}

    double greatest_torque(double direct, double speed, double voltage) const {
        double headroom = limit * limit - direct * direct;
        double emf = speed * (motor.direct_inductance * direct + motor.magnet_flux);
        double reactance = speed * motor.quadrature_inductance;
        double a = reactance * reactance + motor.resistance * motor.resistance;
        double b = motor.resistance * (emf - reactance * direct);
        double c = std::pow(motor.resistance * direct, 2) + emf * emf - voltage * voltage, inside = b * b - a * c;
        if (headroom < 0.0 || inside < 0.0) return -1.0;
        return motor.torque_per_ampere(direct) * std::min(std::sqrt(headroom), (std::sqrt(inside) - b) / a);
    }

    double direct_for(double torque, double speed, double voltage, double trim) const {
        double wanted = std::min(std::abs(torque), most_torque);
        return std::max(weakened(least_current(wanted), wanted, std::abs(speed), voltage) + trim, deepest);
    }

private:
    Motor motor;
    double limit, deepest;

public:
    double most_torque;

private:
    double least_current(double torque) const {
        double saliency = motor.quadrature_inductance - motor.direct_inductance, direct = 0.0;
        if (saliency < 1e-3 * motor.direct_inductance) return 0.0;
        for (int round = 0; round < 6; ++round) {
            double reluctance = 2.0 * saliency * torque / motor.torque_per_ampere(direct);
            direct = (motor.magnet_flux - std::hypot(motor.magnet_flux, reluctance)) / (2.0 * saliency);
        }
        return direct;
    }

    // First direct current from a given one on that allows the torque, else the one that allows most.
    double weakened(double start, double torque, double speed, double voltage) const {
        double best = start, last = start, before = greatest_torque(start, speed, voltage), most = before;
        for (int step = 1; step <= 64 && most < torque; ++step) {
            double direct = start + (deepest - start) * step / 64.0, possible = greatest_torque(direct, speed, voltage);
            if (possible >= torque) return last + (direct - last) * (torque - before) / (possible - before);
            if (possible > most) most = possible, best = direct;
            last = direct, before = possible;
        }
        return best;
    }
};

class Controller {
public:
    Controller(const Motor &motor, const Limits &limits);
    std::array<double, 3> step(const double *currents, double link, double angle, double speed, double demand, bool is_torque);

private:
    Motor motor;
    Limits limits;
    References references;
    PiRegulator direct_regulator, quadrature_regulator, speed_regulator;
    double weakening = 0.0;
};

} // namespace motor_control
