/* signals.h: what a controller is given and answers, as an FMU's variables; of one contract, which build_fmu.py chooses. */
#ifndef SIGNALS_H
#define SIGNALS_H

#include <stddef.h>

#ifdef CONTROLLER_DUTY
#include "drivegate_duty.h"
#define CONTROLLER_PHASES 3
typedef struct signals {
    drivegate_duty_nameplate nameplate;
    drivegate_duty_sense sense;
    drivegate_duty_command command;
    double phase_currents[CONTROLLER_PHASES];
    double hall, encoder_count, trip, enable; /* FMI's reals, as whole numbers have no meaning of "none" there */
    double legs[3], fault;
} signals;
#else
#include "drivegate.h"
#ifndef CONTROLLER_PHASES
#define CONTROLLER_PHASES 5
#endif
typedef struct signals {
    drivegate_nameplate nameplate;
    drivegate_sense sense;
    drivegate_command command;
    double phase_currents[CONTROLLER_PHASES];
} signals;
#endif

/* Forget everything. */
void signals_reset(signals *self);

/* Find a variable by its value reference; NULL when there is none of that type. An array has several values. */
double *signals_real(signals *self, unsigned reference);
int64_t *signals_integer(signals *self, unsigned reference);
size_t signals_width(unsigned reference);

/* Call the controller's functions with them; the first gives what its reset returns. */
int signals_begin(signals *self, void *state);
void signals_step(signals *self, void *state, double time);

#endif
