// Field-oriented control: a speed regulator, the least current for a torque, field weakening, current regulators with
// decoupling and anti-windup, and min-max modulation. Every constant follows from the nameplate; all quantities are in SI
// units.
#include "drivegate_duty.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>

namespace {

constexpr double root_three = 1.7320508075688772;
// Bandwidth of the currents over the sampling rate, of the speed over that, and of the currents' integrals over that.
constexpr double current_share = 0.2, speed_share = 0.02, integral_share = 0.1;
// Share of the voltage limit that references use; the rest is for the current regulators. Braking from a speed to a lower
// one leaves more, for a machine of less inductance than on the nameplate.
constexpr double voltage_share = 0.985, braking_share = 0.185;

// A vector along and across the magnet's axis.
struct Rotor {
    double direct, quadrature;
};

double magnitude(double along, double across) { return std::sqrt(along * along + across * across); }

// Transform currents (A) or voltages (V) of the phases into the frame of the rotor, by Clarke and Park.
Rotor park(const double *phases, double angle) {
    const double along = (2.0 * phases[0] - phases[1] - phases[2]) / 3.0, across = (phases[1] - phases[2]) / root_three;
    const double cosine = std::cos(angle), sine = std::sin(angle);
    return {cosine * along + sine * across, cosine * across - sine * along};
}

// Return the duty ratios for a voltage (V), by inverse Park and Clarke, centred in the link by a zero sequence.
std::array<double, 3> modulate(Rotor voltage, double angle, double supply) {
    const double cosine = std::cos(angle), sine = std::sin(angle);
    const double along = cosine * voltage.direct - sine * voltage.quadrature;
    const double across = 0.5 * root_three * (sine * voltage.direct + cosine * voltage.quadrature);
    std::array<double, 3> phases{along, across - 0.5 * along, -across - 0.5 * along};
    const auto [lowest, highest] = std::minmax_element(phases.begin(), phases.end());
    const double middle = 0.5 * (*highest + *lowest);
    for (double &phase : phases) phase = std::clamp(0.5 + (phase - middle) / supply, 0.0, 1.0);
    return phases;
}

// All that the controller remembers. Its memory is drivegate's; keep nothing in globals, so that many can run.
class Controller {
public:
    // Prepare for a run: made before every one, so it forgets everything.
    explicit Controller(const drivegate_duty_nameplate &nameplate)
        : regulates_torque{nameplate.reference_kind == DRIVEGATE_TORQUE_REFERENCE},
          pole_pairs{static_cast<double>(nameplate.pole_pairs)}, resistance{nameplate.resistance},
          inductance{nameplate.direct_inductance, nameplate.quadrature_inductance},
          saliency{inductance.quadrature - inductance.direct}, flux{nameplate.magnet_flux},
          limit{nameplate.current_limit},
          // Beyond the magnet's whole flux the voltage rises again.
          deepest{-std::min(0.999 * limit, flux / inductance.direct)},
          // From the sample to the middle of the period in which the answer acts (s).
          lead{(static_cast<double>(nameplate.update_delay) + 0.5) * nameplate.control_period} {
        const double bandwidth = current_share / nameplate.control_period;
        gain = {bandwidth * inductance.direct, bandwidth * inductance.quadrature};
        rate = {current_share * std::max(resistance, integral_share * gain.direct),
                current_share * std::max(resistance, integral_share * gain.quadrature)};
        speed_gain = nameplate.inertia * speed_share * bandwidth;
        speed_rate = speed_gain * 0.25 * speed_share * current_share;
        weakening_rate = 0.02 * current_share / (pole_pairs * nameplate.base_speed * inductance.direct);
        // The torque at the current limit, with the direct current that makes it the greatest.
        const double turned = 2.0 * saliency * limit;
        const double direct = -turned * limit / (flux + std::sqrt(flux * flux + 2.0 * turned * turned));
        greatest = per_ampere(direct) * std::sqrt(limit * limit - direct * direct);
    }

    // Answer for one control period.
    void step(const drivegate_duty_sense &sense, drivegate_duty_command &command) {
        const double electrical = pole_pairs * sense.speed, angle = pole_pairs * sense.angle;
        const double supply = std::max(sense.supply_voltage, 1e-9), voltage_limit = supply / root_three;
        if (!sense.enable) {
            preload(sense.phase_voltages, angle, electrical, supply);
            std::fill_n(command.duty_ratios, 3, 0.5);
            return;
        }
        const Rotor current = park(sense.phase_currents, angle);
        const Rotor wanted = references(sense.reference, sense.speed, electrical, voltage_limit);
        const Rotor error{wanted.direct - current.direct, wanted.quadrature - current.quadrature};
        const Rotor voltage = regulate(error, current, electrical, voltage_limit);
        const auto ratios = modulate(voltage, angle + electrical * lead, supply);
        std::copy(ratios.begin(), ratios.end(), command.duty_ratios);
        command.torque = per_ampere(current.direct) * current.quadrature;
    }

private:
    // Let the integrals begin at the back-EMF beyond the nominal one, while the bridge is off.
    void preload(const double *terminals, double angle, double electrical, double supply) {
        // Terminals at the rail of a conducting diode do not show it.
        if (*std::max_element(terminals, terminals + 3) >= supply) return;
        const Rotor induced = park(terminals, angle);
        integral = {induced.direct, induced.quadrature - electrical * flux};
    }

    // Return the currents for what the reference requests, as far as the limits allow (A).
    Rotor references(double reference, double speed, double electrical, double voltage_limit) {
        const double error = reference - speed, sum = speed_integral + speed_rate * error;
        const double torque = regulates_torque ? reference : speed_gain * error + sum;
        // Negative where the torque brakes: the drop of the resistance is then against the back-EMF.
        const double turning = torque < 0.0 ? -electrical : electrical;
        double voltage = voltage_share * voltage_limit;
        if (!regulates_torque && turning < 0.0)
            voltage -= braking_share * voltage_limit * std::min(std::abs(torque) / (0.2 * greatest), 1.0);
        double direct = direct_for(std::min(std::abs(torque), greatest), turning, voltage);
        direct = std::max(direct + weakening, deepest);
        const double most = std::max(possible(direct, turning, voltage), 0.0);
        // The integral of the speed waits while the limits allow less than it requests.
        if (std::abs(torque) <= most || torque * error <= 0.0) speed_integral = sum;
        return {direct, std::clamp(torque, -most, most) / per_ampere(direct)};
    }

    // Return the voltage that brings the currents to their references (V), within the limit.
    Rotor regulate(Rotor error, Rotor current, double electrical, double voltage_limit) {
        // The coupling of the axes and the back-EMF are added in advance.
        const double direct = gain.direct * error.direct + integral.direct
                              - electrical * inductance.quadrature * current.quadrature;
        const double quadrature = gain.quadrature * error.quadrature + integral.quadrature
                                  + electrical * (inductance.direct * current.direct + flux);
        // A voltage beyond the limit is shortened, not turned. What the limit cuts does not enter the integrals.
        const double used = magnitude(direct, quadrature), share = voltage_limit / std::max(voltage_limit, used);
        const double cut = share - 1.0;
        integral.direct += rate.direct * (error.direct + cut * direct / gain.direct);
        integral.quadrature += rate.quadrature * (error.quadrature + cut * quadrature / gain.quadrature);
        // A machine that differs from the nameplate shows in the voltage that is requested.
        weakening += weakening_rate * (0.5 * (1.0 + voltage_share) * voltage_limit - used);
        weakening = std::clamp(weakening, -0.3 * limit, 0.0);
        return {share * direct, share * quadrature};
    }

    // Return the direct current (A) for a torque: the least, weakened for the voltage, or that of most torque.
    double direct_for(double torque, double electrical, double voltage) const {
        double direct = least_current(torque), deeper = deepest;
        if (possible(direct, electrical, voltage) >= torque) return direct;
        for (int halving = 0; halving < 14; ++halving) {
            const double middle = 0.5 * (direct + deeper), found = possible(middle, electrical, voltage);
            const bool falls = possible(middle - 0.001 * limit, electrical, voltage) <= found;
            (found >= torque || falls ? deeper : direct) = middle;
        }
        return deeper;
    }

    // Return the greatest torque at a direct current within both limits (N m), negative if there is none.
    double possible(double direct, double electrical, double voltage) const {
        const double headroom = limit * limit - direct * direct, reactance = electrical * inductance.quadrature;
        const double along = electrical * (inductance.direct * direct + flux);
        // The voltage is a quadratic in the quadrature current: a q^2 + 2 b q + c = 0 at its limit.
        const double a = reactance * reactance + resistance * resistance, b = resistance * (along - reactance * direct);
        const double c = resistance * resistance * direct * direct + along * along - voltage * voltage;
        const double inside = b * b - a * c;
        if (inside < 0.0) return inside;
        return per_ampere(direct) * std::min(std::sqrt(headroom), (std::sqrt(inside) - b) / a);
    }

    // Return the direct current with which a torque needs the least current (A).
    double least_current(double torque) const {
        double direct = 0.0;
        for (int round = 0; round < 6; ++round) {
            const double quadrature = torque / per_ampere(direct), turned = 2.0 * saliency * quadrature;
            direct = -turned * quadrature / (flux + magnitude(flux, turned));
        }
        return direct;
    }

    // Return the torque of one ampere across the magnet's axis (N m/A).
    double per_ampere(double direct) const { return 1.5 * pole_pairs * (flux - saliency * direct); }

    bool regulates_torque;
    double pole_pairs, resistance;
    Rotor inductance;
    double saliency, flux, limit, deepest, lead, greatest;
    Rotor gain, rate, integral{0.0, 0.0};
    double speed_gain, speed_rate, weakening_rate, speed_integral = 0.0, weakening = 0.0;
};

} // namespace

int64_t drivegate_abi_version() { return DRIVEGATE_ABI_VERSION; }

int64_t drivegate_state_size() { return sizeof(Controller); }

int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *nameplate) {
    new (state) Controller{*nameplate};
    return 0;
}

void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    static_cast<Controller *>(state)->step(*sense, *command);
}
