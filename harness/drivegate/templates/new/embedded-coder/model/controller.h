/* The model's interface: what Embedded Coder writes for a model 'controller' with a nonreusable step function. */
#ifndef CONTROLLER_H
#define CONTROLLER_H

#include "rtwtypes.h"

/* External inputs, in counts. */
typedef struct {
    int16_T PhaseCurrents[3];  /* of the converter */
    int16_T PhaseVoltages[3];  /* of the converter, from the negative rail */
    uint16_T LinkVoltage;      /* of the converter */
    uint16_T ElectricalAngle;  /* 65536 to a turn */
    int16_T ElectricalSpeed;
    int16_T Reference;         /* of speed or torque */
    boolean_T Enable;          /* false while the bridge is off */
} ExtU;

/* External outputs, in counts. */
typedef struct {
    uint16_T Compare[3]; /* of the timer, 0 to rtP.PeriodCounts */
    int16_T Torque;
} ExtY;

/* Parameters, in SI units. */
typedef struct {
    real32_T CurrentPerCount;
    real32_T VoltagePerCount;
    real32_T SpeedPerCount;
    real32_T ReferencePerCount;
    real32_T TorquePerCount;
    real32_T PeriodCounts;
    real32_T PolePairs;
    real32_T Resistance;
    real32_T DirectInductance;
    real32_T QuadratureInductance;
    real32_T MagnetFlux;
    real32_T CurrentLimit;
    real32_T GreatestTorque;
    real32_T DeepestDirect;
    real32_T WeakeningStep;
    real32_T Lead;
    real32_T DirectGain;
    real32_T QuadratureGain;
    real32_T DirectStep;
    real32_T QuadratureStep;
    real32_T SpeedGain;
    real32_T SpeedStep;
    boolean_T RegulatesTorque;
} P;

/* States. */
typedef struct {
    real32_T SpeedIntegral;
    real32_T DirectIntegral;
    real32_T QuadratureIntegral;
    real32_T Weakening;
} DW;

extern ExtU rtU;
extern ExtY rtY;
extern P rtP;
extern DW rtDW;

extern void controller_initialize(void);
extern void controller_step(void);

#endif
