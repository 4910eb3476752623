// What drivegate calls: it makes the object in the memory of the harness, and passes signals on.
#include "drivegate_duty.h"
#include "motor_control.hpp"

#include <new>

struct Instance {
    bool is_torque;
    motor_control::Controller controller;
};

int64_t drivegate_abi_version() { return DRIVEGATE_ABI_VERSION; }
int64_t drivegate_state_size() { return sizeof(Instance); }

int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *plate) {
    const motor_control::Motor motor{
        static_cast<double>(plate->pole_pairs), plate->resistance, plate->direct_inductance,
        plate->quadrature_inductance, plate->magnet_flux, plate->inertia};
    const motor_control::Limits limits{
        plate->current_limit, plate->supply_voltage, plate->control_period,
        (static_cast<double>(plate->update_delay) + 0.5) * plate->control_period};
    new (state) Instance{
        plate->reference_kind == DRIVEGATE_TORQUE_REFERENCE, motor_control::Controller{motor, limits}};
    return 0;
}

void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    auto *instance = static_cast<Instance *>(state);
    const auto duty_ratios = instance->controller.step(
        sense->phase_currents, sense->supply_voltage, sense->angle, sense->speed, sense->reference, instance->is_torque);
    std::copy(duty_ratios.begin(), duty_ratios.end(), command->duty_ratios);
}
