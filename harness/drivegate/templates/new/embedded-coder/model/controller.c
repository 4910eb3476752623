/* The model's code; put that of your own model in its place. Field-oriented control in single precision. */
#include "controller.h"

#include <math.h>
#include <string.h>

#define ROOT_THREE 1.73205081F
#define ANGLE_PER_COUNT 9.58737992e-5F
/* Of the undistorted voltage, what references are made for, the rest being for the current regulators; and what is left
 * of it where a speed is braked to, for a machine of less inductance than the parameters say. */
#define VOLTAGE_SHARE 0.985F
#define BRAKING_SHARE 0.185F

ExtU rtU;
ExtY rtY;
P rtP;
DW rtDW;

static real32_T saturate(real32_T value, real32_T lowest, real32_T highest) {
    return value < lowest ? lowest : value > highest ? highest : value;
}

/* Give the torque of an ampere across the magnet's axis. */
static real32_T torque_per_ampere(real32_T direct) {
    return 1.5F * rtP.PolePairs * (rtP.MagnetFlux + (rtP.DirectInductance - rtP.QuadratureInductance) * direct);
}

/* Give the direct current of least magnitude for a torque. */
static real32_T least_current(real32_T torque) {
    real32_T saliency = rtP.QuadratureInductance - rtP.DirectInductance, direct = 0.0F;
    int32_T round;
    for (round = 0; round < 6; round++) {
        real32_T quadrature = torque / torque_per_ampere(direct), turned = 2.0F * saliency * quadrature;
        direct = -turned * quadrature / (rtP.MagnetFlux + hypotf(rtP.MagnetFlux, turned));
    }
    return direct;
}

/* Give the greatest torque at a direct current within the limits of current and voltage; negative for none. */
static real32_T greatest_torque(real32_T direct, real32_T electrical, real32_T voltage) {
    real32_T headroom = rtP.CurrentLimit * rtP.CurrentLimit - direct * direct;
    real32_T along = electrical * (rtP.DirectInductance * direct + rtP.MagnetFlux);
    real32_T reactance = electrical * rtP.QuadratureInductance, resistance = rtP.Resistance;
    /* The voltage is a quadratic in the quadrature current: a q^2 + 2 b q + c = 0 at its limit. */
    real32_T a = reactance * reactance + resistance * resistance;
    real32_T b = resistance * (along - reactance * direct);
    real32_T c = resistance * resistance * direct * direct + along * along - voltage * voltage;
    real32_T inside = b * b - a * c;
    if (inside < 0.0F) return -1.0F;
    return torque_per_ampere(direct) * fminf(sqrtf(headroom), (sqrtf(inside) - b) / a);
}

/* Give the direct current for a torque, at least 0: that of least magnitude, weakened as far as the voltage asks for,
 * or that of the greatest torque where the limits leave less. */
static real32_T direct_for(real32_T torque, real32_T electrical, real32_T voltage) {
    real32_T start = least_current(torque), chosen = start, last = start;
    real32_T greatest = greatest_torque(start, electrical, voltage);
    int32_T step;
    for (step = 1; step <= 64 && greatest < torque; step++) {
        real32_T direct = start + (rtP.DeepestDirect - start) * (real32_T)step / 64.0F;
        real32_T possible = greatest_torque(direct, electrical, voltage);
        if (possible >= torque) {
            int32_T halving;
            for (halving = 0; halving < 8; halving++) {
                real32_T middle = 0.5F * (last + direct);
                if (greatest_torque(middle, electrical, voltage) >= torque) direct = middle;
                else last = middle;
            }
            return direct;
        }
        if (possible > greatest) {
            greatest = possible;
            chosen = direct;
        }
        last = direct;
    }
    return chosen;
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

/* Transform three counts of the converter into the frame of the rotor. */
static void park(const int16_T counts[3], real32_T worth, real32_T angle, real32_T *direct, real32_T *quadrature) {
    real32_T along = worth * (2.0F * (real32_T)counts[0] - (real32_T)counts[1] - (real32_T)counts[2]) / 3.0F;
    real32_T across = worth * ((real32_T)counts[1] - (real32_T)counts[2]) / ROOT_THREE;
    *direct = cosf(angle) * along + sinf(angle) * across;
    *quadrature = cosf(angle) * across - sinf(angle) * along;
}

/* Let the integrals begin at what the back-EMF adds to the nominal one, while the bridge is off. */
static void preload(real32_T angle, real32_T electrical) {
    int32_T leg;
    /* Terminals at the rail of a conducting diode do not show it. */
    for (leg = 0; leg < 3; leg++)
        if (rtU.PhaseVoltages[leg] >= (int32_T)rtU.LinkVoltage) return;
    park(rtU.PhaseVoltages, rtP.VoltagePerCount, angle, &rtDW.DirectIntegral, &rtDW.QuadratureIntegral);
    rtDW.QuadratureIntegral -= electrical * rtP.MagnetFlux;
}

void controller_step(void) {
    real32_T angle, electrical, supply, limit, direct, quadrature, torque;
    real32_T direct_error, quadrature_error, direct_wanted, quadrature_wanted, direct_given, quadrature_given;
    real32_T headroom, share;
    real32_T error = 0.0F, allowed, possible, turning, used;
    angle = (real32_T)rtU.ElectricalAngle * ANGLE_PER_COUNT;
    electrical = (real32_T)rtU.ElectricalSpeed * rtP.SpeedPerCount;
    if (!rtU.Enable) {
        preload(angle, electrical);
        return;
    }
    supply = fmaxf((real32_T)rtU.LinkVoltage * rtP.VoltagePerCount, 1e-6F);
    limit = supply / ROOT_THREE;

    park(rtU.PhaseCurrents, rtP.CurrentPerCount, angle, &direct, &quadrature);
    torque = (real32_T)rtU.Reference * rtP.ReferencePerCount;
    if (!rtP.RegulatesTorque) {
        error = torque - electrical / rtP.PolePairs;
        rtDW.SpeedIntegral += rtP.SpeedStep * error;
        torque = rtP.SpeedGain * error + rtDW.SpeedIntegral;
    }
    allowed = VOLTAGE_SHARE * limit;
    if (!rtP.RegulatesTorque && torque * electrical < 0.0F)
        allowed -= BRAKING_SHARE * limit * fminf(1.0F, fabsf(torque) / (0.2F * rtP.GreatestTorque));
    /* Negative where the torque brakes: the drop of the resistance is then against the back-EMF. */
    turning = torque < 0.0F ? -electrical : electrical;
    direct_error = direct_for(fminf(fabsf(torque), rtP.GreatestTorque), turning, allowed) + rtDW.Weakening;
    direct_error = fmaxf(direct_error, rtP.DeepestDirect);
    headroom = sqrtf(rtP.CurrentLimit * rtP.CurrentLimit - direct_error * direct_error);
    possible = fmaxf(greatest_torque(direct_error, turning, allowed), 0.0F);
    quadrature_error = saturate(torque, -possible, possible) / torque_per_ampere(direct_error);
    quadrature_error = saturate(quadrature_error, -headroom, headroom);
    /* The integral of the speed waits while the limits leave less than it asks for. */
    if (!rtP.RegulatesTorque && fabsf(torque) > possible && torque * error > 0.0F)
        rtDW.SpeedIntegral -= rtP.SpeedStep * error;
    direct_error -= direct;
    quadrature_error -= quadrature;

    /* What each axis is coupled to the other by, and the back-EMF, are added beforehand. */
    direct_wanted = rtP.DirectGain * direct_error + rtDW.DirectIntegral - electrical * rtP.QuadratureInductance * quadrature;
    quadrature_wanted = rtP.QuadratureGain * quadrature_error + rtDW.QuadratureIntegral
                        + electrical * (rtP.DirectInductance * direct + rtP.MagnetFlux);
    /* A voltage beyond the limit is shortened, not turned: one axis alone would never get the other back. */
    used = hypotf(direct_wanted, quadrature_wanted);
    share = used > limit ? limit / used : 1.0F;
    direct_given = share * direct_wanted;
    quadrature_given = share * quadrature_wanted;
    /* What the limit has taken does not enter the integrals. */
    rtDW.DirectIntegral += rtP.DirectStep * (direct_error + (direct_given - direct_wanted) / rtP.DirectGain);
    rtDW.QuadratureIntegral +=
        rtP.QuadratureStep * (quadrature_error + (quadrature_given - quadrature_wanted) / rtP.QuadratureGain);
    /* Where the machine is not as the parameters say, the voltage that is asked for tells. */
    rtDW.Weakening = saturate(rtDW.Weakening + rtP.WeakeningStep * (0.5F * (1.0F + VOLTAGE_SHARE) * limit - used), -0.3F * rtP.CurrentLimit, 0.0F);

    angle += electrical * rtP.Lead;
    compare(cosf(angle) * direct_given - sinf(angle) * quadrature_given,
            sinf(angle) * direct_given + cosf(angle) * quadrature_given, supply);
    torque = torque_per_ampere(direct) * quadrature;
    rtY.Torque = (int16_T)saturate(torque / rtP.TorquePerCount, -32768.0F, 32767.0F);
}

void controller_initialize(void) {
    memset(&rtU, 0, sizeof rtU);
    memset(&rtY, 0, sizeof rtY);
    memset(&rtDW, 0, sizeof rtDW);
}
