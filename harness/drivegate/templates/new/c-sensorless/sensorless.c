/* Start and observer for a machine without a position sensor, around the field-oriented control in regulators.c. While the
 * legs are off, the terminals show whether the shaft turns. A current vector aligns a shaft at rest and turns it up to the
 * least speed, from which an observer of the stator flux shows the angle. All quantities are in SI units.
 * The functions of the control get other names, because their own are those of this controller. */
#define drivegate_abi_version foc_abi_version
#define drivegate_state_size foc_state_size
#define drivegate_duty_reset foc_reset
#define drivegate_duty_step foc_step
#include "regulators.c"
#undef drivegate_abi_version
#undef drivegate_state_size
#undef drivegate_duty_reset
#undef drivegate_duty_step

int64_t drivegate_abi_version(void);
int64_t drivegate_state_size(void);
int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *nameplate);
void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command);

#define PI 3.141592653589793
#define LOST_ROTOR 7 /* code of the fault */
/* Watched control periods; speeds over the least one: that of a turning shaft, of handover, of the return to the vector,
 * and from which the rotor is lost. */
#define WATCHED 60
#define FOLLOWED 100
#define TURNS 0.5
#define HANDOVER 1.05
#define FREE 0.6
#define RETURN 0.7
#define STALLED 0.5
/* Times of agreement, of a lost rotor and of a rotor that the vector holds (s), and the greatest error of the flux (1). */
#define AGREED 0.02
#define LOST 0.02
#define HELD 0.5
#define FLUX_ERROR 0.5
#define START_CURRENT 0.8  /* current of a start over the limit */
#define DEAD_SHARE 0.0005  /* current over the limit from which a dead time acts whole */
#define SMOOTH_SHARE 0.05  /* share by which the currents that decide on it are followed in a control period */
#define SPEED_BANDWIDTH 80 /* least bandwidth of the speed regulator, rad/s */

typedef struct { double along, across; } vector;

enum { WATCHING, ALIGNING, RAMPING, RUNNING };

typedef struct {
    regulators foc;
    drivegate_duty_nameplate plate;
    int mode, age, agreed, lost, fault, turned_periods, align_periods, delay;
    /* Speeds are electrical from here on. */
    double period, least, bandwidth, still_gain, lead, dead_ratio, ripple;
    double start_current, swing, acceleration, damping, fast, slow;
    double field, field_speed, sense_of_start, angle, speed, flux_error, turned;
    vector integral, induced, mean_induced, flux, current, smooth, terminal, acted[2];
} sensorless;

static vector clarke(const double phases[3]) {
    return (vector){(2.0 * phases[0] - phases[1] - phases[2]) / 3.0, (phases[1] - phases[2]) / sqrt(3.0)};
}

static vector turned_by(vector v, double angle) {
    return (vector){cos(angle) * v.along - sin(angle) * v.across, sin(angle) * v.along + cos(angle) * v.across};
}

static double wrapped(double angle) { return remainder(angle, 2.0 * PI); }

static double size_of(vector v) { return sqrt(v.along * v.along + v.across * v.across); }

static int regulates_torque(const sensorless *self) { return self->plate.reference_kind == DRIVEGATE_TORQUE_REFERENCE; }

static void enter(sensorless *self, int mode) {
    self->mode = mode;
    self->age = self->agreed = self->lost = self->turned_periods = 0;
    self->turned = 0.0;
}

/* Set the observer to an angle (rad) and a speed (rad/s) at the present currents. */
static void place_rotor(sensorless *self, double angle, double speed) {
    vector current = turned_by(self->current, -angle);
    self->angle = wrapped(angle);
    self->speed = speed;
    self->flux_error = 0.0;
    self->flux.along = self->plate.direct_inductance * current.along + self->plate.magnet_flux;
    self->flux.across = self->plate.quadrature_inductance * current.across;
    self->flux = turned_by(self->flux, angle);
}

/* Advance the observer to the currents (A) after a voltage that acted (V). After Hinkkanen and others, "Observers for
 * sensorless synchronous motor drives", IEEE Transactions on Industry Applications 54(6), 2018. */
static void observe(sensorless *self, vector current, vector voltage) {
    const drivegate_duty_nameplate *plate = &self->plate;
    double half = 0.5 * plate->resistance, saliency = plate->direct_inductance - plate->quadrature_inductance;
    self->flux.along += self->period * (voltage.along - half * (current.along + self->current.along));
    self->flux.across += self->period * (voltage.across - half * (current.across + self->current.across));
    double angle = self->angle + self->period * self->speed;
    vector own = turned_by(current, -angle), flux = turned_by(self->flux, -angle);
    vector missed = {plate->direct_inductance * own.along + plate->magnet_flux - flux.along,
                     plate->quadrature_inductance * own.across - flux.across};
    vector active = {plate->magnet_flux + saliency * own.along, -saliency * own.across};
    double square = active.along * active.along + active.across * active.across;
    /* The part along the active flux corrects the flux, and the part across it the angle. */
    self->flux_error = (missed.along * active.along + missed.across * active.across) / square;
    double error = (missed.along * active.across - missed.across * active.along) / square;
    double share = 2.0 * self->period * (self->still_gain + 0.2 * fabs(self->speed)) * self->flux_error;
    vector corrected = turned_by((vector){share * active.along, share * active.across}, angle);
    self->flux.along += corrected.along;
    self->flux.across += corrected.across;
    self->speed += self->period * self->bandwidth * self->bandwidth * error;
    self->angle = wrapped(angle + 2.0 * self->period * self->bandwidth * error);
}

/* Follow the voltage that is induced along and across the current vector, without that of a rotor that follows it. */
static void follow_induced(sensorless *self, vector current, vector voltage) {
    double half = 0.5 * self->plate.resistance;
    double rate = 0.5 * (self->plate.direct_inductance + self->plate.quadrature_inductance) / self->period;
    vector before = self->current;
    vector induced = {
        voltage.along - half * (current.along + before.along) - rate * (current.along - before.along),
        voltage.across - half * (current.across + before.across) - rate * (current.across - before.across)};
    induced = turned_by(induced, -self->field);
    induced.across -= self->field_speed * self->plate.magnet_flux;
    self->induced.along += self->fast * (induced.along - self->induced.along);
    self->induced.across += self->fast * (induced.across - self->induced.across);
    self->mean_induced.along += self->slow * (self->induced.along - self->mean_induced.along);
    self->mean_induced.across += self->slow * (self->induced.across - self->mean_induced.across);
}

static void place_field(sensorless *self, double angle, double speed, double current) {
    self->field = wrapped(angle);
    self->field_speed = speed;
    self->induced = self->mean_induced = (vector){0.0, 0.0};
    self->integral = (vector){self->plate.resistance * current, 0.0};
}

/* Turn the current vector at a speed that goes to a target (rad/s), and write the duty ratios of its current. A current
 * against the change of the induced voltage acts as a resistance, which damps the swing of the rotor. */
static void turn_field(sensorless *self, const drivegate_duty_sense *sense, drivegate_duty_command *command, double target) {
    double step = self->acceleration * self->period, limit = sense->supply_voltage / sqrt(3.0);
    double inductance = 0.5 * (self->plate.direct_inductance + self->plate.quadrature_inductance);
    self->field_speed = fmin(fmax(target, self->field_speed - step), self->field_speed + step);
    self->field = wrapped(self->field + self->period * self->field_speed);
    vector wanted = {self->start_current - (self->induced.along - self->mean_induced.along) / self->damping,
                     -(self->induced.across - self->mean_induced.across) / self->damping};
    double share = fmin(1.0, 0.95 * self->plate.current_limit / size_of(wanted));
    vector current = turned_by(self->current, -self->field);
    vector error = {share * wanted.along - current.along, share * wanted.across - current.across};
    double gain = 0.2 * inductance / self->period, integral_step = 0.02 * gain;
    self->integral.along = fmin(fmax(self->integral.along + integral_step * error.along, -limit), limit);
    self->integral.across = fmin(fmax(self->integral.across + integral_step * error.across, -limit), limit);
    vector voltage = {gain * error.along + self->integral.along,
                      gain * error.across + self->integral.across
                          + self->field_speed * (inductance * self->start_current + self->plate.magnet_flux)};
    share = fmin(1.0, limit / fmax(size_of(voltage), 1e-9));
    voltage = turned_by((vector){share * voltage.along, share * voltage.across},
                        self->field + self->lead * self->field_speed);
    double second = -0.5 * voltage.along + 0.5 * sqrt(3.0) * voltage.across;
    double phases[3] = {voltage.along, second, -voltage.along - second};
    double middle = 0.5 * (fmax(phases[0], fmax(phases[1], phases[2])) + fmin(phases[0], fmin(phases[1], phases[2])));
    for (int leg = 0; leg < 3; ++leg) command->duty_ratios[leg] = 0.5 + (phases[leg] - middle) / sense->supply_voltage;
}

/* Return the angle of a rotor that follows the current vector: a quarter turn behind the voltage that it induces. */
static double rotor_of_field(const sensorless *self) {
    double across = self->induced.across + self->field_speed * self->plate.magnet_flux;
    if (fabs(self->field_speed) < 0.2 * self->least) return self->field;
    return self->field + atan2(across, self->induced.along) - copysign(0.5 * PI, self->field_speed);
}

/* Return the sense of rotation that the reference asks for, 0 for none. */
static double wanted_sense(const sensorless *self, const drivegate_duty_sense *sense) {
    double electrical = self->plate.pole_pairs * sense->reference;
    return fabs(electrical) < 0.5 * self->least ? 0.0 : copysign(1.0, electrical);
}

/* Begin field-oriented control from a torque (N m), so that the speed regulator does not start from 0. */
static void run(sensorless *self, double torque) {
    begin_regulators(&self->foc, &self->plate, SPEED_BANDWIDTH, torque);
    enter(self, RUNNING);
}

static double present_torque(const sensorless *self) {
    const drivegate_duty_nameplate *plate = &self->plate;
    vector current = turned_by(self->current, -self->angle);
    double saliency = plate->quadrature_inductance - plate->direct_inductance;
    return 1.5 * plate->pole_pairs * (plate->magnet_flux - saliency * current.along) * current.across;
}

/* Measure the speed of the terminals' voltage while the legs are off; drive a shaft that turns, or start one at rest. */
static void watch(sensorless *self, const drivegate_duty_sense *sense, drivegate_duty_command *command, vector before) {
    for (int leg = 0; leg < 3; ++leg) {
        command->duty_ratios[leg] = 0.5;
        command->legs[leg] = DRIVEGATE_LEG_OFF;
    }
    vector now = self->terminal;
    if (self->age <= self->delay + 1 || size_of(now) <= 0.5 * TURNS * self->least * self->plate.magnet_flux) {
        self->turned = 0.0;
        self->turned_periods = 0;
    } else {
        self->turned += atan2(before.along * now.across - before.across * now.along,
                              before.along * now.along + before.across * now.across);
        self->turned_periods++;
    }
    if (self->age < WATCHED + self->delay + 1) return;
    double speed = self->turned / (fmax(self->turned_periods, 1.0) * self->period);
    if (!self->agreed && self->turned_periods >= WATCHED - 1 && fabs(speed) > TURNS * self->least) {
        place_rotor(self, atan2(now.across, now.along) - copysign(0.5 * PI, speed), speed);
        self->agreed = 1;
    }
    if (self->agreed) {
        /* Diodes that rectify hide the voltage; the observer needs some time then. */
        int rectifies = fabs(self->current.along) + fabs(self->current.across) > 0.02 * self->plate.current_limit;
        if (!rectifies || self->age >= WATCHED + FOLLOWED) run(self, 0.0);
        return;
    }
    self->age = self->delay + 1;
    self->turned = 0.0;
    self->turned_periods = 0;
    double wanted = wanted_sense(self, sense);
    if (regulates_torque(self) || wanted == 0.0) return;
    self->sense_of_start = wanted;
    place_field(self, 0.0, 0.0, 0.0);
    enter(self, ALIGNING);
}

/* Hold the current along one direction and then across it: opposite to the first one a rotor feels no torque. Then measure
 * the resistance. */
static void align(sensorless *self, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    int first = self->align_periods / 2;
    if (self->age == first) self->field = self->sense_of_start * 0.5 * PI;
    turn_field(self, sense, command, 0.0);
    if (self->age < first + self->align_periods) return;
    /* A rotor at rest induces nothing, so what is left of the voltage shows how far the resistance is off. */
    double other = 0.5 * self->plate.resistance, off = self->mean_induced.along / self->start_current;
    self->plate.resistance += fmin(fmax(off, -other), other);
    self->induced = self->mean_induced = (vector){0.0, 0.0};
    place_rotor(self, self->field, 0.0);
    enter(self, RAMPING);
}

/* Turn the current vector up to the speed of handover, and hand over once the observer agrees. */
static void ramp(sensorless *self, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    double wanted = wanted_sense(self, sense), target = wanted * HANDOVER * self->least;
    turn_field(self, sense, command, target);
    if (fabs(self->field_speed) < FREE * self->least) place_rotor(self, rotor_of_field(self), self->field_speed);
    if (self->field_speed != target) {
        self->age = 0;
        return;
    }
    if (wanted == 0.0) {
        if (self->age * self->period > HELD) enter(self, WATCHING);
        return;
    }
    int agrees = fabs(self->speed - target) < 0.1 * fabs(target) && fabs(self->flux_error) < FLUX_ERROR;
    self->agreed = agrees ? self->agreed + 1 : 0;
    if (self->agreed * self->period > AGREED) run(self, present_torque(self));
    else if (self->age * self->period > fmax(3.0 * self->swing, 0.15)) self->fault = LOST_ROTOR;
}

/* Control by the observed angle and speed; below the least speed a reversal returns to the current vector. */
static void drive(sensorless *self, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    drivegate_duty_sense seen = *sense;
    seen.enable = 1;
    seen.angle = self->angle / self->plate.pole_pairs;
    seen.speed = self->speed / self->plate.pole_pairs;
    double wanted = wanted_sense(self, sense), present = fabs(self->speed), torque = present_torque(self);
    if (!regulates_torque(self) && wanted == copysign(1.0, self->speed))
        seen.reference = wanted * fmax(fabs(sense->reference), self->least / self->plate.pole_pairs);
    else if (!regulates_torque(self))
        seen.reference = 0.0;
    foc_step(&self->foc, &seen, command);
    command->angle = seen.angle;
    command->speed = seen.speed;
    if (regulates_torque(self) && present < STALLED * self->least) {
        enter(self, WATCHING);
    } else if (!regulates_torque(self) && seen.reference == 0.0 && present < RETURN * self->least) {
        double most = 1.5 * self->plate.pole_pairs * self->plate.magnet_flux * self->start_current;
        place_field(self, self->angle + acos(fmin(fmax(torque / most, -0.9), 0.9)), self->speed, self->start_current);
        enter(self, RAMPING);
    }
    int is_lost = fabs(self->flux_error) > FLUX_ERROR || (self->mode == RUNNING && present < STALLED * self->least);
    self->lost = is_lost ? self->lost + 1 : 0;
    if (self->lost * self->period > LOST) self->fault = LOST_ROTOR;
}

/* Turn the legs off, or all lower switches on where the EMF is above the link. */
static void stop(const sensorless *self, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    int rectifies = sqrt(3.0) * fabs(self->speed) * self->plate.magnet_flux > sense->supply_voltage;
    for (int leg = 0; leg < 3; ++leg) {
        command->duty_ratios[leg] = 0.5;
        command->legs[leg] = rectifies ? DRIVEGATE_LEG_LOW : DRIVEGATE_LEG_OFF;
    }
    command->fault = self->fault;
}

/* Compensate duty ratios for the dead time, by the signs of the currents while they act. Currents near zero are smoothed in
 * the frame that turns with them: their signs must not follow ripple and noise. */
static void compensate(sensorless *self, double angle, double speed, double ratios[3]) {
    vector current = turned_by(self->current, -angle);
    self->smooth.along += SMOOTH_SHARE * (current.along - self->smooth.along);
    self->smooth.across += SMOOTH_SHARE * (current.across - self->smooth.across);
    current = turned_by(self->smooth, angle + self->lead * speed);
    double second = -0.5 * current.along + 0.5 * sqrt(3.0) * current.across;
    double currents[3] = {current.along, second, -current.along - second};
    double least = DEAD_SHARE * self->plate.current_limit, ripple[3];
    /* A current that has different signs at the two edges of its leg loses no time at either. */
    for (int leg = 0; leg < 3; ++leg) {
        double own = ratios[leg], next = ratios[(leg + 1) % 3], last = ratios[(leg + 2) % 3];
        double earlier = (fmax(next - own, 0.0) + fmax(last - own, 0.0)) / 3.0;
        ripple[leg] = -self->ripple * (earlier + (own - (own + next + last) / 3.0) * (1.0 - own));
    }
    for (int leg = 0; leg < 3; ++leg) {
        double on = (currents[leg] + ripple[leg]) / least, off = (currents[leg] - ripple[leg]) / least;
        double sign = 0.5 * (fmin(fmax(on, -1.0), 1.0) + fmin(fmax(off, -1.0), 1.0));
        ratios[leg] = fmin(fmax(ratios[leg] + self->dead_ratio * sign, 0.0), 1.0);
    }
}

int64_t drivegate_abi_version(void) { return foc_abi_version(); }

int64_t drivegate_state_size(void) { return sizeof(sensorless); }

/* Prepare for a run: called before every one, and must forget everything. */
int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *nameplate) {
    sensorless *self = state;
    *self = (sensorless){.plate = *nameplate};
    double period = nameplate->control_period, flux = nameplate->magnet_flux, inertia = nameplate->inertia;
    double pole_pairs = nameplate->pole_pairs, current = START_CURRENT * nameplate->current_limit;
    double least = nameplate->least_speed > 0.0 ? nameplate->least_speed : 0.1 * nameplate->base_speed;
    double torque = 1.5 * pole_pairs * flux * current, rate = sqrt(pole_pairs * torque / inertia);
    double saliency = 0.5 * fabs(nameplate->quadrature_inductance - nameplate->direct_inductance);
    self->period = period;
    self->delay = nameplate->update_delay > 0;
    self->lead = (nameplate->update_delay + 0.5) * period;
    self->least = pole_pairs * least;
    self->bandwidth = fmin(2.0 * PI * 50.0, 0.05 / period);
    self->still_gain = 0.25 * nameplate->resistance
                       * (1.0 / nameplate->direct_inductance + 1.0 / nameplate->quadrature_inductance);
    /* Current that the whole link drives in half a carrier period. */
    double carrier = nameplate->updates == 2 ? 2.0 * period : period / nameplate->control_every;
    self->dead_ratio = nameplate->dead_time / carrier;
    self->ripple = nameplate->supply_voltage * carrier / (nameplate->direct_inductance + nameplate->quadrature_inductance);
    self->start_current = current;
    self->swing = 2.0 * PI / rate;
    double longest = nameplate->start_time > 0.0 ? fmin(0.5, 0.3 * nameplate->start_time) : 0.5;
    self->align_periods = (int)(fmin(4.0 * self->swing, longest) / period) + 1;
    /* What the load of a start and a reserve leave of the pull-out torque accelerates. */
    double left = fmax(0.8 * torque - 0.5 * nameplate->rated_power / nameplate->base_speed, 0.1 * torque);
    self->acceleration = fmin(pole_pairs * left / inertia, HANDOVER * self->least / (2.0 * self->swing));
    self->damping = rate * flux / (1.8 * current);
    self->fast = fmin(fmin(10.0 * rate, 0.5 * self->damping / fmax(saliency, 1e-9)) * period, 0.5);
    self->slow = 0.3 * rate * period;
    self->acted[0] = self->acted[1] = (vector){NAN, NAN};
    foc_reset(&self->foc, nameplate);
    enter(self, WATCHING);
    return 0;
}

/* Answer for one control period. */
void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    sensorless *self = state;
    if (self->fault != 0) {
        stop(self, sense, command);
        return;
    }
    vector current = clarke(sense->phase_currents), before = self->terminal, acted = self->acted[self->delay];
    self->terminal = clarke(sense->phase_voltages);
    /* While the legs were off, the terminals show the voltage that acted. */
    if (isnan(acted.along))
        acted = (vector){0.5 * (before.along + self->terminal.along), 0.5 * (before.across + self->terminal.across)};
    observe(self, current, acted);
    follow_induced(self, current, acted);
    self->current = current;
    int mode = self->mode;
    if (mode == WATCHING) watch(self, sense, command, before);
    else if (mode == ALIGNING) align(self, sense, command);
    else if (mode == RAMPING) ramp(self, sense, command);
    else drive(self, sense, command);
    self->age++;
    self->acted[1] = self->acted[0];
    self->acted[0] = clarke(command->duty_ratios);
    self->acted[0].along *= mode == WATCHING ? NAN : sense->supply_voltage;
    self->acted[0].across *= sense->supply_voltage;
    if (mode == RUNNING) compensate(self, self->angle, self->speed, command->duty_ratios);
    else if (mode != WATCHING) compensate(self, self->field, self->field_speed, command->duty_ratios);
    if (self->fault != 0) stop(self, sense, command);
}
