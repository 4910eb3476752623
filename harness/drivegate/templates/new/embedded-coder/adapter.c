/* Between drivegate and the model: signals in SI units on one side, counts on the other. */
#include "controller.h"
#include "drivegate_duty.h"

#include <math.h>

#define TURN 6.283185307179586

/* What one count is worth, on the drive of this run. Converters and timer are those of your board. */
static struct {
    double pole_pairs, current, voltage, angle, speed, reference, torque, period_counts;
} scale;

/* The model's inputs: field of rtU, its type, what one count is worth, and the signal. */
#define INPUTS(ROW) \
    ROW(PhaseCurrents[0], int16_T, scale.current, sense->phase_currents[0]) \
    ROW(PhaseCurrents[1], int16_T, scale.current, sense->phase_currents[1]) \
    ROW(PhaseCurrents[2], int16_T, scale.current, sense->phase_currents[2]) \
    ROW(PhaseVoltages[0], int16_T, scale.voltage, sense->phase_voltages[0]) \
    ROW(PhaseVoltages[1], int16_T, scale.voltage, sense->phase_voltages[1]) \
    ROW(PhaseVoltages[2], int16_T, scale.voltage, sense->phase_voltages[2]) \
    ROW(LinkVoltage, uint16_T, scale.voltage, sense->supply_voltage) \
    ROW(ElectricalAngle, uint16_T, scale.angle, within_a_turn(scale.pole_pairs * sense->angle)) \
    ROW(ElectricalSpeed, int16_T, scale.speed, scale.pole_pairs * sense->speed) \
    ROW(Reference, int16_T, scale.reference, sense->reference) \
    ROW(Enable, boolean_T, 1.0, (double)sense->enable)

/* Its outputs: field of rtY, what one count is worth, and where it goes. */
#define OUTPUTS(ROW) \
    ROW(Compare[0], 1.0 / scale.period_counts, command->duty_ratios[0]) \
    ROW(Compare[1], 1.0 / scale.period_counts, command->duty_ratios[1]) \
    ROW(Compare[2], 1.0 / scale.period_counts, command->duty_ratios[2]) \
    ROW(Torque, scale.torque, command->torque)

/* Its parameters: field of rtP, and its value. */
#define PARAMETERS(ROW) \
    ROW(CurrentPerCount, scale.current) \
    ROW(VoltagePerCount, scale.voltage) \
    ROW(SpeedPerCount, scale.speed) \
    ROW(ReferencePerCount, scale.reference) \
    ROW(TorquePerCount, scale.torque) \
    ROW(PeriodCounts, scale.period_counts) \
    ROW(PolePairs, plate->pole_pairs) \
    ROW(Resistance, plate->resistance) \
    ROW(DirectInductance, plate->direct_inductance) \
    ROW(QuadratureInductance, plate->quadrature_inductance) \
    ROW(MagnetFlux, plate->magnet_flux) \
    ROW(CurrentLimit, plate->current_limit) \
    ROW(GreatestTorque, most_torque(plate)) \
    ROW(DeepestDirect, -fmin(0.999 * plate->current_limit, plate->magnet_flux / plate->direct_inductance)) \
    ROW(WeakeningStep, \
        0.02 * CURRENT_SHARE / ((double)plate->pole_pairs * plate->base_speed * plate->direct_inductance)) \
    ROW(Lead, ((double)plate->update_delay + 0.5) * plate->control_period) \
    ROW(DirectGain, bandwidth * plate->direct_inductance) \
    ROW(QuadratureGain, bandwidth * plate->quadrature_inductance) \
    ROW(DirectStep, CURRENT_SHARE * fmax(plate->resistance, INTEGRAL_SHARE * bandwidth * plate->direct_inductance)) \
    ROW(QuadratureStep, \
        CURRENT_SHARE * fmax(plate->resistance, INTEGRAL_SHARE * bandwidth * plate->quadrature_inductance)) \
    ROW(SpeedGain, plate->inertia * SPEED_SHARE * bandwidth) \
    ROW(SpeedStep, plate->inertia * SPEED_SHARE * bandwidth * 0.25 * SPEED_SHARE * CURRENT_SHARE) \
    ROW(RegulatesTorque, plate->reference_kind == DRIVEGATE_TORQUE_REFERENCE)

/* Bandwidth of the currents over the sampling rate, which a delay of one and a half periods bears, that of the speed
 * over it, and that of their integrals. */
#define CURRENT_SHARE 0.2
#define SPEED_SHARE 0.02
#define INTEGRAL_SHARE 0.1

static double within_a_turn(double angle) { return angle - TURN * floor(angle / TURN); }

/* Convert to counts: to the nearest, and to the end of the type's range beyond it. */
static double counts(double value, double worth, double lowest, double highest) {
    return fmin(fmax(floor(value / worth + 0.5), lowest), highest);
}

/* Give the torque at the current limit where the voltage is free: the best of all angles of the current. */
static double most_torque(const drivegate_duty_nameplate *plate) {
    double saliency = plate->quadrature_inductance - plate->direct_inductance, greatest = 0.0;
    for (int degree = 0; degree < 90; ++degree) {
        double direct = -plate->current_limit * sin(degree * TURN / 360.0);
        double quadrature = plate->current_limit * cos(degree * TURN / 360.0);
        greatest = fmax(greatest, 1.5 * (double)plate->pole_pairs * (plate->magnet_flux - saliency * direct) * quadrature);
    }
    return greatest;
}

/* Ends of a type's range, since generated headers define them for some types only: real types have none. */
#define IS_REAL(type) ((type)0.5 > (type)0)
#define IS_SIGNED(type) ((type)-1 < (type)1)
#define LOWEST(type) (IS_SIGNED(type) ? -ldexp(1.0, 8 * (int)sizeof(type) - 1) : 0.0)
#define HIGHEST(type) (ldexp(1.0, 8 * (int)sizeof(type) - IS_SIGNED(type)) - 1.0)
#define CONVERTED(type, worth, signal) \
    (type)(IS_REAL(type) ? (signal) / (worth) : counts(signal, worth, LOWEST(type), HIGHEST(type)))

static void set_scales(const drivegate_duty_nameplate *plate) {
    scale.pole_pairs = (double)plate->pole_pairs;
    scale.current = plate->current_limit / 8192.0;
    scale.voltage = plate->supply_voltage / 2048.0;
    scale.angle = TURN / 65536.0;
    scale.speed = 2.0 * scale.pole_pairs * plate->highest_speed / 32768.0;
    scale.torque = most_torque(plate) / 8192.0;
    scale.reference = plate->reference_kind == DRIVEGATE_TORQUE_REFERENCE ? scale.torque : 2.0 * plate->highest_speed / 32768.0;
    scale.period_counts = 8400.0;
}

static void set_parameters(const drivegate_duty_nameplate *plate) {
    double bandwidth = CURRENT_SHARE / plate->control_period;
#define SET(field, value) rtP.field = (value);
    PARAMETERS(SET)
#undef SET
}

int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }

/* The model's state is in globals. */
int64_t drivegate_state_size(void) { return 0; }

/* Prepare for a run: called before every one, and must forget everything. */
int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *plate) {
    (void)state;
    set_scales(plate);
    controller_initialize();
    set_parameters(plate);
    return 0;
}

/* Answer for one control period. */
void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    (void)state;
#define READ(field, type, worth, signal) rtU.field = CONVERTED(type, worth, signal);
    INPUTS(READ)
#undef READ
    controller_step();
#define WRITE(field, worth, signal) signal = (double)rtY.field * (worth);
    OUTPUTS(WRITE)
#undef WRITE
}
