/* instance.h: one instance of a drivegate controller as an FMU sees it, whatever the version of FMI. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stdarg.h>
#include <stddef.h>

#include "drivegate.h"

#ifndef CONTROLLER_PHASES
#define CONTROLLER_PHASES 5
#endif

/* Value references, as build_fmu.py writes them into modelDescription.xml. */
enum {
    SPEED_REFERENCE = 1,
    SPEED,
    CURRENT_MAGNITUDE_SUM,
    HALF_SUPPLY_VOLTAGE,
    CURRENT_REFERENCE = 11,
    ADVANCE_ANGLE,
    INPUT_POWER,
    PHASES = 21,
    POLE_PAIRS,
    KIND,
    NOMINAL_HALF_SUPPLY_VOLTAGE = 31,
    BASE_SPEED,
    RATED_POWER,
    CURRENT_LIMIT,
    CONTROL_PERIOD,
    HYSTERESIS_BAND,
    RESISTANCE,
    INDUCTANCE,
    EMF_CONSTANT,
    INERTIA,
    WINDOW,
    CONDUCTING_PHASES,
    ADVANCE_START,
    ADVANCE_SLOPE,
    HIGHEST_SPEED,
    PHASE_CURRENTS = 101 /* the first one; the others follow */
};

typedef void report_function(void *environment, const char *message);

typedef struct instance {
    drivegate_nameplate nameplate;
    drivegate_sense sense;
    drivegate_command command;
    double phase_currents[CONTROLLER_PHASES];
    void *state; /* of the controller; NULL where it keeps its state in globals */
    report_function *report;
    void *environment; /* first argument of `report` */
} instance;

/* Make an instance; NULL, after a report, when there cannot be one. */
instance *instance_new(const char *token, report_function *report, void *environment);
void instance_free(instance *self);

/* Forget everything: as after instance_new. */
void instance_reset(instance *self);

/* Find a variable by its value reference; NULL when there is none of that type. */
double *instance_real(instance *self, unsigned reference);
int64_t *instance_integer(instance *self, unsigned reference);

/* Each returns 0 for success, and reports anything else. */
int instance_begin(instance *self);
int instance_step(instance *self, double time, double period);

/* Report to the importer what is wrong; always returns 1. */
int instance_report(instance *self, const char *format, ...);

#endif
