"""Controllers of duty ratios in C, most of which do one thing that a controller must not do."""

from __future__ import annotations

SOURCE = """#include "drivegate_duty.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
%(top)s
typedef struct { double pole_pairs, flux; int64_t steps; } controller;
%(version)s
int64_t drivegate_state_size(void) { return sizeof(controller); }
int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *plate) {
    controller *self = state;
    *self = (controller){.pole_pairs = (double)plate->pole_pairs, .flux = plate->magnet_flux};
    %(reset)s
    return 0;
}
/* The voltage of the back-EMF, ahead of the magnet. */
void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    controller *self = state;
    self->steps += 1;
    double electrical = self->pole_pairs * sense->speed;
    double share = fmin(electrical * self->flux / sense->supply_voltage, 0.5);
    for (int leg = 0; leg < 3; ++leg)
        command->duty_ratios[leg] = 0.5 - share * sin(self->pole_pairs * sense->angle - leg * 2.0943951023931953);
    if (self->steps == 5) { %(fifth_step)s }
}
"""
VERSION = "int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }"


def duty_source(*, top: str = "", reset: str = "", fifth_step: str = "", version: str = VERSION) -> str:
    """Write a controller that does something particular in its reset or in its fifth step."""
    return SOURCE % {"top": top, "reset": reset, "fifth_step": fifth_step, "version": version}
