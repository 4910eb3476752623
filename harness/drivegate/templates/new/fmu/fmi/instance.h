/* instance.h: one instance of a drivegate controller as an FMU sees it, whatever the version of FMI. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stdarg.h>
#include <stddef.h>

#include "signals.h"

typedef void report_function(void *environment, const char *message);

typedef struct instance {
    signals signals;
    void *state; /* of the controller; NULL where it keeps its state in globals */
    report_function *report;
    void *environment; /* first argument of `report` */
} instance;

/* Make an instance; NULL, after a report, when there cannot be one. */
instance *instance_new(const char *token, report_function *report, void *environment);
void instance_free(instance *self);

/* Forget everything: as after instance_new. */
void instance_reset(instance *self);

/* Each returns 0 for success, and reports anything else. */
int instance_begin(instance *self);
int instance_step(instance *self, double time, double period);

/* Report to the importer what is wrong; always returns 1. */
int instance_report(instance *self, const char *format, ...);

#endif
