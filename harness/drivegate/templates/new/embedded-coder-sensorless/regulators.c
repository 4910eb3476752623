/* The field-oriented control of the model behind adapter.c, as sensorless.c uses it. */
#include "adapter.c"

/* The model's state is in globals. */
typedef char regulators;

/* Begin from a torque (N m), with a speed regulator of a least bandwidth (rad/s). */
static void begin_regulators(regulators *foc, const drivegate_duty_nameplate *plate, double bandwidth, double torque) {
    foc_reset(foc, plate);
    double faster = fmax(bandwidth * plate->inertia / rtP.SpeedGain, 1.0);
    rtP.SpeedGain = (real32_T)(faster * rtP.SpeedGain);
    rtP.SpeedStep = (real32_T)(faster * faster * rtP.SpeedStep);
    rtDW.SpeedIntegral = (real32_T)torque;
}
