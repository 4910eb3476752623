/* The field-oriented control of controller.c, as sensorless.c uses it. */
#include "controller.c"

typedef controller regulators;

/* Begin from a torque (N m), with a speed regulator of a least bandwidth (rad/s). */
static void begin_regulators(regulators *foc, const drivegate_duty_nameplate *plate, double bandwidth, double torque) {
    foc_reset(foc, plate);
    double faster = fmax(bandwidth * plate->inertia / foc->speed_gain, 1.0);
    foc->speed_gain *= faster;
    foc->speed_step *= faster * faster;
    foc->speed_integral = torque;
}
