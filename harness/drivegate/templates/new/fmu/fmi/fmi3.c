/* fmi3.c: a drivegate controller behind the functions of FMI 3.0 for co-simulation. */
#include <stdlib.h>

#include "fmi3Functions.h"
#include "instance.h"

typedef struct component {
    instance *controller;
    fmi3LogMessageCallback logger;
    fmi3InstanceEnvironment environment;
} component;

static void report(void *environment, const char *message) {
    component *self = environment;
    if (self->logger) self->logger(self->environment, fmi3Error, "logStatusError", message);
}

static instance *controller_of(fmi3Instance c) { return ((component *)c)->controller; }

static fmi3Status status_of(int failed) { return failed ? fmi3Error : fmi3OK; }

static fmi3Status unsupported(fmi3Instance c, const char *function) {
    return status_of(instance_report(controller_of(c), "%s is not supported", function));
}

static fmi3Status unknown(fmi3Instance c, const char *function) {
    return status_of(instance_report(controller_of(c), "%s: there is no such variable of this type", function));
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String categories[]) {
    (void)c, (void)on, (void)count, (void)categories;
    return fmi3OK; /* only errors are reported, and always */
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events,
                                         fmi3Boolean early, const fmi3ValueReference required[], size_t count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update) {
    (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early, (void)required;
    (void)count, (void)update;
    component *self = calloc(1, sizeof *self);
    if (!self) return NULL;
    self->logger = logger;
    self->environment = environment;
    if ((self->controller = instance_new(token, report, self))) return self;
    free(self);
    return NULL;
}

void fmi3FreeInstance(fmi3Instance c) {
    if (!c) return;
    instance_free(controller_of(c));
    free(c);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean with_tolerance, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean with_stop, fmi3Float64 stop) {
    (void)c, (void)with_tolerance, (void)tolerance, (void)start, (void)with_stop, (void)stop;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return status_of(instance_begin(controller_of(c))); }

fmi3Status fmi3Terminate(fmi3Instance c) {
    (void)c;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c) {
    instance_reset(controller_of(c));
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t count,
                          const fmi3Float64 values[], size_t total) {
    (void)total;
    for (size_t i = 0; i < count; i++) {
        double *variable = signals_real(&controller_of(c)->signals, references[i]);
        if (!variable) return unknown(c, "fmi3SetFloat64");
        for (size_t k = signals_width(references[i]); k > 0; k--) *variable++ = *values++;
    }
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t count,
                          fmi3Float64 values[], size_t total) {
    (void)total;
    for (size_t i = 0; i < count; i++) {
        double *variable = signals_real(&controller_of(c)->signals, references[i]);
        if (!variable) return unknown(c, "fmi3GetFloat64");
        for (size_t k = signals_width(references[i]); k > 0; k--) *values++ = *variable++;
    }
    return fmi3OK;
}

fmi3Status fmi3SetInt64(fmi3Instance c, const fmi3ValueReference references[], size_t count,
                        const fmi3Int64 values[], size_t total) {
    (void)total;
    for (size_t i = 0; i < count; i++) {
        int64_t *variable = signals_integer(&controller_of(c)->signals, references[i]);
        if (!variable) return unknown(c, "fmi3SetInt64");
        *variable = values[i];
    }
    return fmi3OK;
}

fmi3Status fmi3GetInt64(fmi3Instance c, const fmi3ValueReference references[], size_t count, fmi3Int64 values[],
                        size_t total) {
    (void)total;
    for (size_t i = 0; i < count; i++) {
        int64_t *variable = signals_integer(&controller_of(c)->signals, references[i]);
        if (!variable) return unknown(c, "fmi3GetInt64");
        values[i] = *variable;
    }
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 period, fmi3Boolean no_return,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    (void)no_return;
    *event = *terminate = *early = false;
    *reached = time + period;
    return status_of(instance_step(controller_of(c), time, period));
}

/* The rest of FMI 3.0 is optional for co-simulation; importers still look for the functions. */
#pragma GCC diagnostic ignored "-Wunused-parameter"

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger) {
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                               fmi3ClockUpdateCallback clock, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock) {
    return NULL;
}

typedef fmi3ValueReference reference;
typedef fmi3IntervalQualifier qualifier;

#define UNSUPPORTED(function, ...)                                                                                    \
    fmi3Status function(fmi3Instance c, __VA_ARGS__) { return unsupported(c, #function); }
#define UNSUPPORTED_ALONE(function)                                                                                   \
    fmi3Status function(fmi3Instance c) { return unsupported(c, #function); }
#define UNSUPPORTED_TYPE(type)                                                                                        \
    UNSUPPORTED(fmi3Get##type, const reference r[], size_t n, fmi3##type v[], size_t m)                               \
    UNSUPPORTED(fmi3Set##type, const reference r[], size_t n, const fmi3##type v[], size_t m)

UNSUPPORTED_TYPE(Float32)
UNSUPPORTED_TYPE(Int8)
UNSUPPORTED_TYPE(UInt8)
UNSUPPORTED_TYPE(Int16)
UNSUPPORTED_TYPE(UInt16)
UNSUPPORTED_TYPE(Int32)
UNSUPPORTED_TYPE(UInt32)
UNSUPPORTED_TYPE(UInt64)
UNSUPPORTED_TYPE(Boolean)
UNSUPPORTED_TYPE(String)
UNSUPPORTED(fmi3GetBinary, const reference r[], size_t n, size_t sizes[], fmi3Binary v[], size_t m)
UNSUPPORTED(fmi3SetBinary, const reference r[], size_t n, const size_t sizes[], const fmi3Binary v[], size_t m)
UNSUPPORTED(fmi3GetClock, const reference r[], size_t n, fmi3Clock v[])
UNSUPPORTED(fmi3SetClock, const reference r[], size_t n, const fmi3Clock v[])
UNSUPPORTED(fmi3GetNumberOfVariableDependencies, reference r, size_t *count)
UNSUPPORTED(fmi3GetVariableDependencies, reference r, size_t elements[], reference independents[],
            size_t independent_elements[], fmi3DependencyKind kinds[], size_t count)
UNSUPPORTED(fmi3GetFMUState, fmi3FMUState *state)
UNSUPPORTED(fmi3SetFMUState, fmi3FMUState state)
UNSUPPORTED(fmi3FreeFMUState, fmi3FMUState *state)
UNSUPPORTED(fmi3SerializedFMUStateSize, fmi3FMUState state, size_t *size)
UNSUPPORTED(fmi3SerializeFMUState, fmi3FMUState state, fmi3Byte bytes[], size_t size)
UNSUPPORTED(fmi3DeserializeFMUState, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
UNSUPPORTED(fmi3GetDirectionalDerivative, const reference u[], size_t nu, const reference k[], size_t nk,
            const fmi3Float64 seed[], size_t seeds, fmi3Float64 v[], size_t m)
UNSUPPORTED(fmi3GetAdjointDerivative, const reference u[], size_t nu, const reference k[], size_t nk,
            const fmi3Float64 seed[], size_t seeds, fmi3Float64 v[], size_t m)
UNSUPPORTED(fmi3GetIntervalDecimal, const reference r[], size_t n, fmi3Float64 v[], qualifier q[])
UNSUPPORTED(fmi3GetIntervalFraction, const reference r[], size_t n, fmi3UInt64 v[], fmi3UInt64 of[], qualifier q[])
UNSUPPORTED(fmi3GetShiftDecimal, const reference r[], size_t n, fmi3Float64 v[])
UNSUPPORTED(fmi3GetShiftFraction, const reference r[], size_t n, fmi3UInt64 v[], fmi3UInt64 of[])
UNSUPPORTED(fmi3SetIntervalDecimal, const reference r[], size_t n, const fmi3Float64 v[])
UNSUPPORTED(fmi3SetIntervalFraction, const reference r[], size_t n, const fmi3UInt64 v[], const fmi3UInt64 of[])
UNSUPPORTED(fmi3SetShiftDecimal, const reference r[], size_t n, const fmi3Float64 v[])
UNSUPPORTED(fmi3SetShiftFraction, const reference r[], size_t n, const fmi3UInt64 v[], const fmi3UInt64 of[])
UNSUPPORTED(fmi3UpdateDiscreteStates, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals,
            fmi3Boolean *values, fmi3Boolean *has_next, fmi3Float64 *next)
UNSUPPORTED(fmi3CompletedIntegratorStep, fmi3Boolean no_return, fmi3Boolean *event, fmi3Boolean *terminate)
UNSUPPORTED(fmi3SetTime, fmi3Float64 time)
UNSUPPORTED(fmi3SetContinuousStates, const fmi3Float64 v[], size_t n)
UNSUPPORTED(fmi3GetContinuousStateDerivatives, fmi3Float64 v[], size_t n)
UNSUPPORTED(fmi3GetEventIndicators, fmi3Float64 v[], size_t n)
UNSUPPORTED(fmi3GetContinuousStates, fmi3Float64 v[], size_t n)
UNSUPPORTED(fmi3GetNominalsOfContinuousStates, fmi3Float64 v[], size_t n)
UNSUPPORTED(fmi3GetNumberOfEventIndicators, size_t *n)
UNSUPPORTED(fmi3GetNumberOfContinuousStates, size_t *n)
UNSUPPORTED(fmi3GetOutputDerivatives, const reference r[], size_t n, const fmi3Int32 order[], fmi3Float64 v[], size_t m)
UNSUPPORTED(fmi3ActivateModelPartition, reference clock, fmi3Float64 time)
UNSUPPORTED_ALONE(fmi3EnterEventMode)
UNSUPPORTED_ALONE(fmi3EnterConfigurationMode)
UNSUPPORTED_ALONE(fmi3ExitConfigurationMode)
UNSUPPORTED_ALONE(fmi3EvaluateDiscreteStates)
UNSUPPORTED_ALONE(fmi3EnterContinuousTimeMode)
UNSUPPORTED_ALONE(fmi3EnterStepMode)
