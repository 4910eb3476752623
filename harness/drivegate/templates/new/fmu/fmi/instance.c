/* instance.c: calls the functions of a controller as an FMU's life goes on. */
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

void instance_reset(instance *self) { signals_reset(&self->signals); }

int instance_begin(instance *self) {
    int64_t size = drivegate_state_size();
    if (size > 0) memset(self->state, 0, (size_t)size);
    int refused = signals_begin(&self->signals, self->state);
    return refused ? instance_report(self, "drivegate_reset returned %d", refused) : 0;
}

int instance_step(instance *self, double time, double period) {
    double known = self->signals.nameplate.control_period;
    if (fabs(period - known) > 1e-6 * period)
        return instance_report(self, "the communication step is %g s, but the parameter control_period is %g s",
                               period, known);
    signals_step(&self->signals, self->state, time);
    return 0;
}
