/* The model's code; put that of your own model in its place. Field-oriented control in single precision. */
#include "controller.h"

#include <math.h>
#include <string.h>

#define ROOT_THREE 1.73205081F
#define ANGLE_PER_COUNT 9.58737992e-5F

ExtU rtU;
ExtY rtY;
P rtP;
DW rtDW;

static real32_T saturate(real32_T value, real32_T lowest, real32_T highest) {
    return value < lowest ? lowest : value > highest ? highest : value;
}

/* Give the torque for an error of speed; the integral waits while the limit leaves nothing to do. */
static real32_T regulate(real32_T error) {
    real32_T integral = rtDW.SpeedIntegral + rtP.SpeedStep * error;
    real32_T torque = rtP.SpeedGain * error + integral;
    if (fabsf(torque) < rtP.GreatestTorque || torque * error < 0.0F) rtDW.SpeedIntegral = integral;
    return saturate(torque, -rtP.GreatestTorque, rtP.GreatestTorque);
}

/* Give the currents of least magnitude for a torque, as far as their limit allows. */
static void references(real32_T torque, real32_T *direct, real32_T *quadrature) {
    real32_T saliency = rtP.QuadratureInductance - rtP.DirectInductance, magnitude;
    int32_T round;
    *direct = 0.0F;
    *quadrature = torque / (1.5F * rtP.PolePairs * rtP.MagnetFlux);
    if (saliency > 1e-3F * rtP.DirectInductance) {
        for (round = 0; round < 6; round++) {
            *direct = (rtP.MagnetFlux - hypotf(rtP.MagnetFlux, 2.0F * saliency * *quadrature)) / (2.0F * saliency);
            *quadrature = torque / (1.5F * rtP.PolePairs * (rtP.MagnetFlux - saliency * *direct));
        }
    }
    /* Your weakening would add its own part to the direct current here (checks FWK-1 to FWK-3). */
    magnitude = hypotf(*direct, *quadrature);
    if (magnitude > rtP.CurrentLimit) {
        *direct *= rtP.CurrentLimit / magnitude;
        *quadrature *= rtP.CurrentLimit / magnitude;
    }
}

/* Write the compare counts of a voltage in the frame that stands still, about the middle of the link. */
static void compare(real32_T along, real32_T across, real32_T supply) {
    real32_T phases[3], highest, lowest;
    int32_T leg;
    phases[0] = along;
    phases[1] = -0.5F * along + 0.5F * ROOT_THREE * across;
    phases[2] = -0.5F * along - 0.5F * ROOT_THREE * across;
    highest = fmaxf(phases[0], fmaxf(phases[1], phases[2]));
    lowest = fminf(phases[0], fminf(phases[1], phases[2]));
    for (leg = 0; leg < 3; leg++) {
        real32_T ratio = 0.5F + (phases[leg] - 0.5F * (highest + lowest)) / supply;
        rtY.Compare[leg] = (uint16_T)(saturate(ratio, 0.0F, 1.0F) * rtP.PeriodCounts + 0.5F);
    }
}

void controller_step(void) {
    real32_T currents[3], angle, electrical, supply, limit, along, across, direct, quadrature, torque;
    real32_T direct_error, quadrature_error, direct_wanted, quadrature_wanted, direct_given, quadrature_given, room;
    int32_T leg;
    for (leg = 0; leg < 3; leg++) currents[leg] = (real32_T)rtU.PhaseCurrents[leg] * rtP.CurrentPerCount;
    angle = (real32_T)rtU.ElectricalAngle * ANGLE_PER_COUNT;
    electrical = (real32_T)rtU.ElectricalSpeed * rtP.SpeedPerCount;
    supply = fmaxf((real32_T)rtU.LinkVoltage * rtP.VoltagePerCount, 1e-6F);
    limit = supply / ROOT_THREE;

    along = (2.0F * currents[0] - currents[1] - currents[2]) / 3.0F;
    across = (currents[1] - currents[2]) / ROOT_THREE;
    direct = cosf(angle) * along + sinf(angle) * across;
    quadrature = cosf(angle) * across - sinf(angle) * along;

    torque = (real32_T)rtU.Reference * rtP.ReferencePerCount;
    if (!rtP.RegulatesTorque) torque = regulate(torque - electrical / rtP.PolePairs);
    references(torque, &direct_error, &quadrature_error);
    direct_error -= direct;
    quadrature_error -= quadrature;

    /* What each axis is coupled to the other by, and the back-EMF, are added beforehand. */
    direct_wanted = rtP.DirectGain * direct_error + rtDW.DirectIntegral - electrical * rtP.QuadratureInductance * quadrature;
    quadrature_wanted = rtP.QuadratureGain * quadrature_error + rtDW.QuadratureIntegral
                        + electrical * (rtP.DirectInductance * direct + rtP.MagnetFlux);
    direct_given = saturate(direct_wanted, -limit, limit);
    room = sqrtf(fmaxf(limit * limit - direct_given * direct_given, 0.0F));
    quadrature_given = saturate(quadrature_wanted, -room, room);
    /* What the limit has taken does not enter the integrals. */
    rtDW.DirectIntegral += rtP.DirectStep * (direct_error + (direct_given - direct_wanted) / rtP.DirectGain);
    rtDW.QuadratureIntegral +=
        rtP.QuadratureStep * (quadrature_error + (quadrature_given - quadrature_wanted) / rtP.QuadratureGain);

    angle += electrical * rtP.Lead;
    compare(cosf(angle) * direct_given - sinf(angle) * quadrature_given,
            sinf(angle) * direct_given + cosf(angle) * quadrature_given, supply);
    torque = 1.5F * rtP.PolePairs * quadrature;
    torque *= rtP.MagnetFlux - (rtP.QuadratureInductance - rtP.DirectInductance) * direct;
    rtY.Torque = (int16_T)saturate(torque / rtP.TorquePerCount, -32768.0F, 32767.0F);
}

void controller_initialize(void) {
    memset(&rtU, 0, sizeof rtU);
    memset(&rtY, 0, sizeof rtY);
    memset(&rtDW, 0, sizeof rtDW);
}
