/* The field-oriented control of controller.c, as sensorless.c uses it. */
#define drivegate_abi_version foc_abi_version
#define drivegate_state_size foc_state_size
#define drivegate_duty_reset foc_reset
#define drivegate_duty_step foc_step
#include "controller.c"
#undef drivegate_abi_version
#undef drivegate_state_size
#undef drivegate_duty_reset
#undef drivegate_duty_step

typedef controller regulators;

/* Begin from a torque (N m), with a speed regulator of a least bandwidth (rad/s). */
static void begin_regulators(regulators *foc, const drivegate_duty_nameplate *plate, double bandwidth, double torque) {
    foc_reset(foc, plate);
    double faster = fmax(bandwidth * plate->inertia / foc->speed_gain, 1.0);
    foc->speed_gain *= faster;
    foc->speed_step *= faster * faster;
    foc->speed_integral = torque;
}
