/* fmi2.c: a drivegate controller behind the functions of FMI 2.0 for co-simulation. */
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "instance.h"

typedef struct component {
    instance *controller;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    char *name;
} component;

static void report(void *environment, const char *message) {
    component *self = environment;
    if (self->logger)
        self->logger(self->environment, self->name ? self->name : "", fmi2Error, "logStatusError", "%s", message);
}

static fmi2Status status_of(int failed) { return failed ? fmi2Error : fmi2OK; }

static fmi2Status unsupported(fmi2Component c, const char *function) {
    return status_of(instance_report(((component *)c)->controller, "%s is not supported", function));
}

static fmi2Status unknown(fmi2Component c, const char *function, unsigned reference) {
    instance *controller = ((component *)c)->controller;
    return status_of(instance_report(controller, "%s: there is no variable %u of this type", function, reference));
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[]) {
    (void)c, (void)on, (void)count, (void)categories;
    return fmi2OK; /* only errors are reported, and always */
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    (void)resources, (void)visible, (void)logging;
    component *self = calloc(1, sizeof *self);
    if (!self) return NULL;
    self->logger = functions ? functions->logger : NULL;
    self->environment = functions ? functions->componentEnvironment : NULL;
    if ((self->name = malloc(strlen(name) + 1))) strcpy(self->name, name);
    if (type == fmi2CoSimulation) self->controller = instance_new(token, report, self);
    if (self->controller) return self;
    free(self->name);
    free(self);
    return NULL;
}

void fmi2FreeInstance(fmi2Component c) {
    component *self = c;
    if (!self) return;
    instance_free(self->controller);
    free(self->name);
    free(self);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean with_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean with_stop, fmi2Real stop) {
    (void)c, (void)with_tolerance, (void)tolerance, (void)start, (void)with_stop, (void)stop;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    return status_of(instance_begin(((component *)c)->controller));
}

fmi2Status fmi2Terminate(fmi2Component c) {
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    instance_reset(((component *)c)->controller);
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t count,
                       const fmi2Real values[]) {
    for (size_t i = 0; i < count; i++) {
        double *variable = signals_real(&((component *)c)->controller->signals, references[i]);
        if (!variable) return unknown(c, "fmi2SetReal", references[i]);
        *variable = values[i];
    }
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Real values[]) {
    for (size_t i = 0; i < count; i++) {
        double *variable = signals_real(&((component *)c)->controller->signals, references[i]);
        if (!variable) return unknown(c, "fmi2GetReal", references[i]);
        values[i] = *variable;
    }
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference references[], size_t count,
                          const fmi2Integer values[]) {
    for (size_t i = 0; i < count; i++) {
        int64_t *variable = signals_integer(&((component *)c)->controller->signals, references[i]);
        if (!variable) return unknown(c, "fmi2SetInteger", references[i]);
        *variable = values[i];
    }
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference references[], size_t count,
                          fmi2Integer values[]) {
    for (size_t i = 0; i < count; i++) {
        int64_t *variable = signals_integer(&((component *)c)->controller->signals, references[i]);
        if (!variable) return unknown(c, "fmi2GetInteger", references[i]);
        values[i] = (fmi2Integer)*variable;
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real period, fmi2Boolean no_return) {
    (void)no_return;
    return status_of(instance_step(((component *)c)->controller, time, period));
}

/* The rest of FMI 2.0 is optional for co-simulation; importers still look for the functions. */
#define UNSUPPORTED(function, ...)                                                                                    \
    fmi2Status function(fmi2Component c, __VA_ARGS__) { return unsupported(c, #function); }

#pragma GCC diagnostic ignored "-Wunused-parameter"

UNSUPPORTED(fmi2GetBoolean, const fmi2ValueReference r[], size_t n, fmi2Boolean v[])
UNSUPPORTED(fmi2SetBoolean, const fmi2ValueReference r[], size_t n, const fmi2Boolean v[])
UNSUPPORTED(fmi2GetString, const fmi2ValueReference r[], size_t n, fmi2String v[])
UNSUPPORTED(fmi2SetString, const fmi2ValueReference r[], size_t n, const fmi2String v[])
UNSUPPORTED(fmi2GetFMUstate, fmi2FMUstate *state)
UNSUPPORTED(fmi2SetFMUstate, fmi2FMUstate state)
UNSUPPORTED(fmi2FreeFMUstate, fmi2FMUstate *state)
UNSUPPORTED(fmi2SerializedFMUstateSize, fmi2FMUstate state, size_t *size)
UNSUPPORTED(fmi2SerializeFMUstate, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
UNSUPPORTED(fmi2DeSerializeFMUstate, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
UNSUPPORTED(fmi2GetDirectionalDerivative, const fmi2ValueReference u[], size_t nu, const fmi2ValueReference k[],
            size_t nk, const fmi2Real dk[], fmi2Real du[])
UNSUPPORTED(fmi2SetRealInputDerivatives, const fmi2ValueReference r[], size_t n, const fmi2Integer order[],
            const fmi2Real v[])
UNSUPPORTED(fmi2GetRealOutputDerivatives, const fmi2ValueReference r[], size_t n, const fmi2Integer order[],
            fmi2Real v[])
UNSUPPORTED(fmi2GetStatus, const fmi2StatusKind kind, fmi2Status *v)
UNSUPPORTED(fmi2GetRealStatus, const fmi2StatusKind kind, fmi2Real *v)
UNSUPPORTED(fmi2GetIntegerStatus, const fmi2StatusKind kind, fmi2Integer *v)
UNSUPPORTED(fmi2GetBooleanStatus, const fmi2StatusKind kind, fmi2Boolean *v)
UNSUPPORTED(fmi2GetStringStatus, const fmi2StatusKind kind, fmi2String *v)

fmi2Status fmi2CancelStep(fmi2Component c) { return unsupported(c, "fmi2CancelStep"); }
