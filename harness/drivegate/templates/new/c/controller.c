/* A speed regulator, and an advance angle that rises with speed by a straight line. */
#include "drivegate.h"
#include <math.h>

#define PI 3.141592653589793

/* All that the controller remembers. The buffer is drivegate's; keep nothing in globals, so that many can run. */
typedef struct {
    double proportional, integral_step, limit, base_speed, advance_start, advance_slope, integral;
} controller;

int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }

int64_t drivegate_state_size(void) { return sizeof(controller); }

/* Prepare for a run: called before every one, and must forget everything. */
int drivegate_reset(void *state, const drivegate_nameplate *nameplate) {
    controller *self = state;
    /* The torque that one ampere gives (N m/A). */
    double torque_per_ampere = nameplate->conducting_phases * nameplate->emf_constant;
    /* The speed follows its reference with 80 rad/s, and the integral with 15 rad/s, on a drive of 576 rad/s
     * electrical at base speed; on others in proportion. */
    double rate = (double)nameplate->pole_pairs * nameplate->base_speed / 575.9586531581288;
    self->proportional = nameplate->inertia * (80.0 * rate) / torque_per_ampere;
    self->integral_step = self->proportional * (15.0 * rate) * nameplate->control_period;
    self->limit = nameplate->current_limit;
    self->base_speed = nameplate->base_speed;
    self->advance_start = nameplate->advance_start;
    self->advance_slope = nameplate->advance_slope;
    self->integral = 0.0;
    return 0;
}

static double between(double lowest, double highest, double value) { return fmin(fmax(value, lowest), highest); }

/* Give the current reference (A); the integral waits while the limits leave nothing to do. */
static double regulate(controller *self, double error) {
    double integral = self->integral + self->integral_step * error;
    double reference = self->proportional * error + integral, limited = between(0.0, self->limit, reference);
    if (limited == reference) self->integral = integral;
    return limited;
}

/* Give the advance angle (rad, electrical). Below base speed it must be 0 exactly (check ADV-1). */
static double angle(const controller *self, double speed) {
    if (speed < self->base_speed) return 0.0;
    /* Your search for the angle of least input power would add its own part here (check CNV-2). */
    return between(0.0, 0.5 * PI, self->advance_start + self->advance_slope * (speed - self->base_speed));
}

/* Answer for one control period; all quantities are in SI units. */
void drivegate_step(void *state, const drivegate_sense *sense, drivegate_command *command) {
    controller *self = state;
    command->current_reference = regulate(self, sense->speed_reference - sense->speed);
    command->advance_angle = angle(self, sense->speed);
    /* An estimate of the input power; leave it out if the controller makes none. */
    command->input_power = sense->half_supply_voltage * sense->current_magnitude_sum;
}
