/* instance.c: calls the four functions of drivegate.h as an FMU's life goes on. */
#include "instance.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef FMU_TOKEN
#error "build_fmu.py defines FMU_TOKEN, which modelDescription.xml has too"
#endif

static int live; /* instances that there are */

int instance_report(instance *self, const char *format, ...) {
    char message[512];
    va_list values;
    va_start(values, format);
    vsnprintf(message, sizeof message, format, values);
    va_end(values);
    self->report(self->environment, message);
    return 1;
}

instance *instance_new(const char *token, report_function *report, void *environment) {
    instance *self = calloc(1, sizeof *self);
    if (!self) return NULL;
    self->report = report;
    self->environment = environment;
    int64_t size = drivegate_state_size();
    if (!token || strcmp(token, FMU_TOKEN) != 0) {
        instance_report(self, "modelDescription.xml belongs to another build");
    } else if (drivegate_abi_version() / 1000 != DRIVEGATE_ABI_MAJOR) {
        instance_report(self, "the controller is built for another version of drivegate.h");
    } else if (size == 0 && live > 0) {
        instance_report(self, "the controller keeps its state in globals, so there can be one instance only");
    } else if (size > 0 && !(self->state = calloc(1, (size_t)size))) {
        instance_report(self, "there is no memory for the controller's state");
    } else {
        live++;
        instance_reset(self);
        return self;
    }
    free(self);
    return NULL;
}

void instance_free(instance *self) {
    if (!self) return;
    free(self->state);
    free(self);
    live--;
}

void instance_reset(instance *self) {
    memset(&self->nameplate, 0, sizeof self->nameplate);
    memset(&self->sense, 0, sizeof self->sense);
    memset(self->phase_currents, 0, sizeof self->phase_currents);
    self->nameplate.struct_size = sizeof self->nameplate;
    self->sense.struct_size = sizeof self->sense;
    self->sense.phase_count = CONTROLLER_PHASES;
    self->sense.phase_currents = self->phase_currents;
    self->command = (drivegate_command){sizeof self->command, 0.0, 0.0, NAN};
}

double *instance_real(instance *self, unsigned reference) {
    drivegate_nameplate *nameplate = &self->nameplate;
    if (reference >= PHASE_CURRENTS && reference < PHASE_CURRENTS + CONTROLLER_PHASES)
        return &self->phase_currents[reference - PHASE_CURRENTS];
    switch (reference) {
    case SPEED_REFERENCE: return &self->sense.speed_reference;
    case SPEED: return &self->sense.speed;
    case CURRENT_MAGNITUDE_SUM: return &self->sense.current_magnitude_sum;
    case HALF_SUPPLY_VOLTAGE: return &self->sense.half_supply_voltage;
    case CURRENT_REFERENCE: return &self->command.current_reference;
    case ADVANCE_ANGLE: return &self->command.advance_angle;
    case INPUT_POWER: return &self->command.input_power;
    case NOMINAL_HALF_SUPPLY_VOLTAGE: return &nameplate->half_supply_voltage;
    case BASE_SPEED: return &nameplate->base_speed;
    case RATED_POWER: return &nameplate->rated_power;
    case CURRENT_LIMIT: return &nameplate->current_limit;
    case CONTROL_PERIOD: return &nameplate->control_period;
    case HYSTERESIS_BAND: return &nameplate->hysteresis_band;
    case RESISTANCE: return &nameplate->resistance;
    case INDUCTANCE: return &nameplate->inductance;
    case EMF_CONSTANT: return &nameplate->emf_constant;
    case INERTIA: return &nameplate->inertia;
    case WINDOW: return &nameplate->window;
    case CONDUCTING_PHASES: return &nameplate->conducting_phases;
    case ADVANCE_START: return &nameplate->advance_start;
    case ADVANCE_SLOPE: return &nameplate->advance_slope;
    case HIGHEST_SPEED: return &nameplate->highest_speed;
    default: return NULL;
    }
}

int64_t *instance_integer(instance *self, unsigned reference) {
    switch (reference) {
    case PHASES: return &self->nameplate.phases;
    case POLE_PAIRS: return &self->nameplate.pole_pairs;
    case KIND: return &self->nameplate.kind;
    default: return NULL;
    }
}

int instance_begin(instance *self) {
    int64_t size = drivegate_state_size();
    if (size > 0) memset(self->state, 0, (size_t)size);
    int refused = drivegate_reset(self->state, &self->nameplate);
    return refused ? instance_report(self, "drivegate_reset returned %d", refused) : 0;
}

int instance_step(instance *self, double time, double period) {
    if (fabs(period - self->nameplate.control_period) > 1e-6 * period)
        return instance_report(self, "the communication step is %g s, but the parameter control_period is %g s",
                               period, self->nameplate.control_period);
    self->sense.time = time;
    self->command = (drivegate_command){sizeof self->command, NAN, NAN, NAN};
    drivegate_step(self->state, &self->sense, &self->command);
    return 0;
}
