// A speed regulator, and an advance angle that rises with speed by a straight line.
#include "drivegate.h"

#include <algorithm>
#include <new>

namespace {

constexpr double pi = 3.141592653589793;

// All that the controller remembers. Its memory is drivegate's; keep nothing in globals, so that many can run.
class Controller {
public:
    // Prepare for a run: made before every one, so it forgets everything.
    explicit Controller(const drivegate_nameplate &nameplate)
        : limit{nameplate.current_limit}, base_speed{nameplate.base_speed}, advance_start{nameplate.advance_start},
          advance_slope{nameplate.advance_slope} {
        // The torque of one ampere (N m/A).
        const double torque_per_ampere = nameplate.conducting_phases * nameplate.emf_constant;
        // The speed follows its reference with 80 rad/s, and the integral with 15 rad/s, on a drive of 576 rad/s
        // electrical at base speed; on others in proportion.
        const double rate = static_cast<double>(nameplate.pole_pairs) * nameplate.base_speed / 575.9586531581288;
        proportional = nameplate.inertia * (80.0 * rate) / torque_per_ampere;
        integral_step = proportional * (15.0 * rate) * nameplate.control_period;
    }

    // Answer for one control period; all quantities are in SI units.
    void step(const drivegate_sense &sense, drivegate_command &command) {
        command.current_reference = regulate(sense.speed_reference - sense.speed);
        command.advance_angle = angle(sense.speed);
        // An estimate of the input power; leave it out if the controller makes none.
        command.input_power = sense.half_supply_voltage * sense.current_magnitude_sum;
    }

private:
    // Return the current reference (A); the integral waits while the limits leave nothing to do.
    double regulate(double error) {
        const double next = integral + integral_step * error;
        const double reference = proportional * error + next, limited = std::clamp(reference, 0.0, limit);
        if (limited == reference) integral = next;
        return limited;
    }

    // Return the advance angle (rad, electrical). Below base speed it must be 0 exactly (check ADV-1).
    double angle(double speed) const {
        if (speed < base_speed) return 0.0;
        // Your search for the angle of least input power would add its own part here (check CNV-2).
        return std::clamp(advance_start + advance_slope * (speed - base_speed), 0.0, 0.5 * pi);
    }

    double limit, base_speed, advance_start, advance_slope, proportional, integral_step, integral = 0.0;
};

} // namespace

int64_t drivegate_abi_version() { return DRIVEGATE_ABI_VERSION; }

int64_t drivegate_state_size() { return sizeof(Controller); }

int drivegate_reset(void *state, const drivegate_nameplate *nameplate) {
    new (state) Controller{*nameplate};
    return 0;
}

void drivegate_step(void *state, const drivegate_sense *sense, drivegate_command *command) {
    static_cast<Controller *>(state)->step(*sense, *command);
}
