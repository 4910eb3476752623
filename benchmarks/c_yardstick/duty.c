/* The closed loop of duty ratios by hand in C: a PM AC machine behind ideal switches, one centred pulse a period.
 *
 * Segments between the edges of the gates by the derivatives of the currents at both ends, as drivegate has them, all of a
 * period at once where no current turns near zero, zeros and extremes of the phase currents to rounding, the whole ledger
 * and its check in every control period. It knows constant references, load and link, and ideal sensors. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "drivegate_duty.h"

enum { MAGNITUDE, SQUARE, IMPULSE, UPPER, LOWER, EXCHANGED, RETURNED, DEVICE, SWITCHING, CORE, DRAG, PEAK, EVENTS, ENTRIES };
enum { COLUMNS = 6 };

#define PI 3.14159265358979323846
#define HALF_ROOT 0.8660254037844386
/* Segments over the time of the fastest rate: the longest, and up to where lower orders will do. */
#define SHORT 0.05
#define SHORTEST 0.008
/* Share of the current limit that is no current. */
#define NOTHING 1e-13

typedef void step_function(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command);

typedef struct {
    double resistance, direct, quadrature, flux, core, inertia, friction, viscous, current_limit;
    double pole_pairs, link, load, reference, period, speed;
    int64_t steps;
    step_function *step;
    void *state;
    drivegate_duty_command fresh;
} task;

typedef struct { double d, q, cosine, sine; } frame;
typedef struct { double value, slope, bend, jerk; } jet;
typedef struct { jet d, q; } currents;
typedef struct {
    double w, dd, dq, qd, qq, per_d, per_q, opposed, rate, pace, bend;
} rates;
typedef struct { double value, slope; } phase;

static inline currents derivatives(const rates *r, double d, double q, double vd, double vq) {
    const double sd = r->dd * d + r->dq * q + vd, sq = r->qd * d + r->qq * q + (vq - r->opposed);
    const double bd = r->dd * sd + r->dq * (sq + vq), bq = r->qd * (sd + vd) + r->qq * sq;
    const double td = r->dq * vq, tq = r->qd * vd;
    return (currents){{d, sd, bd, r->dd * bd + r->dq * (bq + tq)}, {q, sq, bq, r->qd * (bd + td) + r->qq * bq}};
}

static inline currents standing(const currents *c, double w) {
    const jet d = c->d, q = c->q;
    return (currents){
        {d.value, d.slope - w * q.value, d.bend - 2 * w * q.slope - w * w * d.value,
         d.jerk - 3 * w * (q.bend + w * d.slope) + w * w * w * q.value},
        {q.value, q.slope + w * d.value, q.bend + 2 * w * d.slope - w * w * q.value,
         q.jerk + 3 * w * (d.bend - w * q.slope) - w * w * w * d.value}};
}

static inline void taylor(const rates *r, const currents *c, double vd, double vq, double t, int last, double *d, double *q) {
    double power = 0.5 * t * t, ld = c->d.jerk, lq = c->q.jerk;
    double sd = t * c->d.slope + power * c->d.bend, sq = t * c->q.slope + power * c->q.bend;
    power *= t * (1.0 / 3.0);
    sd += power * ld;
    sq += power * lq;
    const double turn = r->dq * r->qd;
    vd *= turn;
    vq *= turn;
    for (int order = 4; order <= last; order++) {
        const double nd = r->dd * ld + r->dq * (lq + vq), nq = r->qd * (ld + vd) + r->qq * lq;
        const double od = r->dq * vq;
        vq = r->qd * vd;
        vd = od;
        ld = nd;
        lq = nq;
        power *= t * (1.0 / order);
        sd += power * ld;
        sq += power * lq;
    }
    *d = c->d.value + sd;
    *q = c->q.value + sq;
}

static inline double of_phase(int leg, double along, double across) {
    return leg == 0 ? along : -0.5 * along + (leg == 1 ? HALF_ROOT : -HALF_ROOT) * across;
}

/* A phase current and its slope a time after the start of a segment. */
static phase phase_at(const rates *r, const currents *c, const frame *f, double vd, double vq, double t, int leg) {
    double d, q;
    taylor(r, c, vd, vq, t, 8, &d, &q);
    const double a = r->w * t, co = cos(a), si = sin(a);
    const double tvd = co * vd + si * vq, tvq = co * vq - si * vd;
    const double sd = r->dd * d + r->dq * q + tvd - r->w * q, sq = r->qd * d + r->qq * q + (tvq - r->opposed) + r->w * d;
    const double C = f->cosine * co - f->sine * si, S = f->sine * co + f->cosine * si;
    return (phase){of_phase(leg, C * d - S * q, S * d + C * q), of_phase(leg, C * sd - S * sq, S * sd + C * sq)};
}

/* Where value or slope of a phase current, of opposite signs at both ends, is zero. */
static double zero_of(const rates *r, const currents *c, const frame *f, double vd, double vq, double t, int leg, int slope) {
    double low = 0.0, high = t, at = 0.5 * t;
    const phase begin = phase_at(r, c, f, vd, vq, 0.0, leg);
    const double sign = (slope ? begin.slope : begin.value) > 0.0 ? 1.0 : -1.0;
    for (int k = 0; k < 60 && high - low > 1e-15 * t; k++) {
        const phase here = phase_at(r, c, f, vd, vq, at, leg);
        const double error = slope ? here.slope : here.value;
        if (sign * error > 0.0) low = at; else high = at;
        const double next = slope || here.slope == 0.0 ? 0.5 * (low + high) : at - error / here.slope;
        at = low < next && next < high ? next : 0.5 * (low + high);
    }
    return at;
}

static inline double part(const double weight[4], const jet *j) {
    return weight[0] * j->value + weight[1] * j->slope + weight[2] * j->bend + weight[3] * j->jerk;
}

static inline jet square_of(const currents *c) {
    const jet d = c->d, q = c->q;
    return (jet){d.value * d.value + q.value * q.value, 2 * (d.value * d.slope + q.value * q.slope),
                 2 * (d.slope * d.slope + q.slope * q.slope + d.value * d.bend + q.value * q.bend),
                 2 * (3 * (d.slope * d.bend + q.slope * q.bend) + d.value * d.jerk + q.value * q.jerk)};
}

static inline jet torque_of(const task *k, const currents *c) {
    const double saliency = k->direct - k->quadrature;
    const jet f = {k->flux + saliency * c->d.value, saliency * c->d.slope, saliency * c->d.bend, saliency * c->d.jerk};
    const jet q = c->q;
    return (jet){f.value * q.value, f.slope * q.value + f.value * q.slope,
                 f.bend * q.value + 2 * f.slope * q.slope + f.value * q.bend,
                 f.jerk * q.value + 3 * (f.bend * q.slope + f.slope * q.bend) + f.value * q.jerk};
}

typedef struct { double square, torque, along, across; } sums;

/* How far the slope of a phase current can change in half of a segment. */
static inline double change_of(const rates *r, const currents *b, double length) {
    const double reach = r->pace * length;
    const double size = fabs(b->d.bend) + fabs(b->q.bend) + length * (fabs(b->d.jerk) + fabs(b->q.jerk));
    return 0.5 * length * (size + 0.5 * reach * reach * r->bend);
}

static inline sums sums_between(const task *k, const rates *r, const currents *begin, const currents *end, const frame *f,
                                const frame *after, double length, int shortest) {
    const double l2 = length * length;
    double weight[4] = {0.5 * length, (3.0 / 28) * l2, (1.0 / 84) * l2 * length, (1.0 / 1680) * l2 * l2};
    if (shortest) {
        weight[1] = 0.1 * l2;
        weight[2] = (1.0 / 120) * l2 * length;
        weight[3] = 0.0;
    }
    const double behind[4] = {weight[0], -weight[1], weight[2], -weight[3]};
    const currents b = standing(begin, r->w), e = standing(end, r->w);
    const jet sb = square_of(begin), se = square_of(end), tb = torque_of(k, begin), te = torque_of(k, end);
    const double bd = part(weight, &b.d), bq = part(weight, &b.q), ed = part(behind, &e.d), eq = part(behind, &e.q);
    return (sums){part(weight, &sb) + part(behind, &se), part(weight, &tb) + part(behind, &te),
                  f->cosine * bd - f->sine * bq + (after->cosine * ed - after->sine * eq),
                  f->sine * bd + f->cosine * bq + (after->sine * ed + after->cosine * eq)};
}

/* Pass a segment with the voltages of three legs, and add it to the ledger. */
static frame pass(const task *k, const rates *r, frame f, const int upper[3], double length, double *totals) {
    const double v0 = upper[0] * k->link, v1 = upper[1] * k->link, v2 = upper[2] * k->link;
    const double along = (2 * v0 - v1 - v2) * (1.0 / 3.0), across = (v1 - v2) * (0.5 / HALF_ROOT);
    const double raw_d = f.cosine * along + f.sine * across, raw_q = f.cosine * across - f.sine * along;
    const double vd = raw_d * r->per_d, vq = raw_q * r->per_q;
    const currents begin = derivatives(r, f.d, f.q, vd, vq);
    const int shortest = r->rate * length <= SHORTEST;
    double d, q;
    taylor(r, &begin, vd, vq, length, shortest ? 6 : 8, &d, &q);
    const double a = r->w * length, s = a * a;
    const double co = 1 - s * (0.5 - s * (1.0 / 24 - s * (1.0 / 720 - s * (1.0 / 40320))));
    const double si = a * (1 - s * (1.0 / 6 - s * (1.0 / 120 - s * (1.0 / 5040 - s * (1.0 / 362880)))));
    const currents end = derivatives(r, d, q, (co * raw_d + si * raw_q) * r->per_d, (co * raw_q - si * raw_d) * r->per_q);
    const frame after = {d, q, f.cosine * co - f.sine * si, f.sine * co + f.cosine * si};
    const currents b = standing(&begin, r->w), e = standing(&end, r->w);
    const double change = change_of(r, &b, length);
    const double ba = f.cosine * f.d - f.sine * f.q, bb = f.sine * f.d + f.cosine * f.q;
    const double ea = after.cosine * d - after.sine * q, eb = after.sine * d + after.cosine * q;
    const double bsa = f.cosine * b.d.slope - f.sine * b.q.slope, bsb = f.sine * b.d.slope + f.cosine * b.q.slope;
    const double esa = after.cosine * e.d.slope - after.sine * e.q.slope;
    const double esb = after.sine * e.d.slope + after.cosine * e.q.slope;
    double peak = totals[PEAK];
    for (int leg = 0; leg < 3; leg++) {
        const double first = of_phase(leg, ba, bb), last = of_phase(leg, ea, eb);
        const double none = NOTHING * k->current_limit;
        if (first * last < 0.0 && fabs(first) > none && fabs(last) > none) {
            const double at = zero_of(r, &begin, &f, vd, vq, length, leg, 0);
            return pass(k, r, pass(k, r, f, upper, at, totals), upper, length - at, totals);
        }
        const double bs = of_phase(leg, bsa, bsb), es = of_phase(leg, esa, esb);
        double top = fmax(fabs(first), fabs(last));
        const int monotone = fmin(bs, es) > change || fmax(bs, es) < -change;
        if (!monotone && bs * es < 0.0 && top + 0.25 * length * change > peak)
            top = fmax(top, fabs(phase_at(r, &begin, &f, vd, vq, zero_of(r, &begin, &f, vd, vq, length, leg, 1), leg).value));
        peak = fmax(peak, top);
    }
    totals[PEAK] = peak;
    const sums all = sums_between(k, r, &begin, &end, &f, &after, length, shortest);
    totals[SQUARE] += 1.5 * all.square;
    totals[IMPULSE] += 1.5 * k->pole_pairs * all.torque;
    const int on = upper[0] + upper[1] + upper[2];
    for (int leg = 0; leg < 3; leg++) {
        const double charge = of_phase(leg, all.along, all.across), magnitude = fabs(charge);
        totals[MAGNITUDE] += magnitude;
        if ((on == 1 && upper[leg]) || (on == 2 && !upper[leg])) {
            const double exchanged = k->link * magnitude, taken = k->link * (on == 1 ? charge : -charge);
            totals[UPPER] += 0.5 * taken;
            totals[LOWER] += 0.5 * taken;
            totals[EXCHANGED] += exchanged;
            totals[RETURNED] += 0.5 * (exchanged - taken);
        }
    }
    totals[EVENTS] += 1;
    return after;
}

#include "period.h"

static rates rates_of(const task *k, double speed, double d, double q) {
    const double w = k->pole_pairs * speed, turning = fabs(w);
    const double least = fmin(k->direct, k->quadrature), greatest = fmax(k->direct, k->quadrature);
    const double growth = (k->resistance + turning * (greatest - least)) / least, pace = growth + 4 * turning;
    const double forced = (2.0 / 3) * k->link / least + turning * fabs(k->flux) / k->quadrature;
    const double size = (sqrt(d * d + q * q) + forced * k->period) * (1 + 2 * growth * k->period);
    return (rates){w, -k->resistance / k->direct, w * k->quadrature / k->direct, -w * k->direct / k->quadrature,
                   -k->resistance / k->quadrature, 1 / k->direct, 1 / k->quadrature, w * k->flux / k->quadrature,
                   turning + k->resistance / least, pace, pace * (forced + growth * size)};
}

/* Advance by one control period. */
static void advance(const task *k, double angle, double speed, const double ratio[3], double *d, double *q, double *totals) {
    const rates r = rates_of(k, speed, *d, *q);
    frame f = {*d, *q, cos(angle), sin(angle)};
    const double pd = k->direct * f.d + k->flux, pq = k->quadrature * f.q;
    const double fa = f.cosine * pd - f.sine * pq, fb = f.sine * pd + f.cosine * pq;
    double edge[3][2];
    int upper[3];
    for (int leg = 0; leg < 3; leg++) {
        const double share = fmin(fmax(ratio[leg], 0.0), 1.0);
        const int full = share >= 1.0;
        edge[leg][0] = full ? 0.0 : 0.5 * (1 - share) * k->period;
        edge[leg][1] = full ? k->period : 0.5 * (1 + share) * k->period;
        upper[leg] = edge[leg][0] <= 0.0;
    }
    const double longest = SHORT / r.rate;
    const int is_passed = pass_period(k, &r, &f, edge, totals);
    for (double time = is_passed ? k->period : 0.0; time < k->period;) {
        double limit = k->period;
        for (int leg = 0; leg < 3; leg++) {
            if (edge[leg][0] > time) limit = fmin(limit, edge[leg][0]);
            else if (edge[leg][1] > time) limit = fmin(limit, edge[leg][1]);
        }
        limit = fmin(limit, time + longest);
        f = pass(k, &r, f, upper, limit - time, totals);
        time = limit;
        for (int leg = 0; leg < 3; leg++) upper[leg] = edge[leg][0] <= time && time < edge[leg][1];
    }
    const double ed = k->direct * f.d + k->flux, eq = k->quadrature * f.q;
    const double da = f.cosine * ed - f.sine * eq - fa, db = f.sine * ed + f.cosine * eq - fb;
    totals[CORE] += 1.5 * k->core * (da * da + db * db) / k->period;
    *d = f.d;
    *q = f.q;
}

/* Run the loop; return the worst residual of the energy in a period over its throughput. */
DRIVEGATE_EXPORT double duty_yardstick_run(const task *k, double *totals, double *rows) {
    double d = 0.0, q = 0.0, angle = 0.0, speed = k->speed, change = 0.0, worst = 0.0, stored = 0.0, sensed[3] = {0.0};
    double ratios[2][3] = {{0.0}};
    drivegate_duty_sense sense = {.struct_size = sizeof sense, .phase_currents = sensed, .hall = -1, .encoder_count = -1};
    for (int64_t n = 0; n < k->steps; n++) {
        sense.time = n * k->period;
        sense.reference = k->reference;
        sense.supply_voltage = k->link;
        sense.angle = angle / k->pole_pairs;
        sense.speed = speed;
        drivegate_duty_command command = k->fresh;
        k->step(k->state, &sense, &command);
        memcpy(ratios[1], command.duty_ratios, sizeof ratios[1]);
        double period[ENTRIES] = {0.0};
        const double held = speed + 0.5 * change;
        /* Until the first answer acts all legs are off: no current flows, and the shaft supplies the core loss. */
        const double flux = k->pole_pairs * k->flux, drag = n ? 0.0 : 1.5 * k->core * flux * flux * held;
        if (n) advance(k, angle, held, ratios[0], &d, &q, period);
        const double now = 0.75 * (k->direct * d * d + k->quadrature * q * q), shaft = held * period[IMPULSE];
        const double net = period[UPPER] + period[LOWER];
        const double missing = net - k->resistance * period[SQUARE] - shaft - (now - stored);
        const double rated = k->link * k->current_limit * k->period;
        const double through = fmax(period[EXCHANGED] + fabs(shaft) + now, 1e-6 * rated);
        worst = fmax(worst, fabs(missing) / through);
        stored = now;
        const double peak = fmax(totals[PEAK], period[PEAK]);
        for (int entry = 0; entry < ENTRIES; entry++) totals[entry] += period[entry];
        totals[PEAK] = peak;
        sense.supply_current = (net + period[CORE]) / (k->link * k->period);
        if (rows) {
            const double row[COLUMNS] = {speed, period[IMPULSE] / k->period, d, q, period[PEAK], (net + period[CORE]) / k->period};
            memcpy(rows + n * COLUMNS, row, sizeof row);
        }
        angle += k->pole_pairs * held * k->period;
        angle -= 2 * PI * floor(angle * (0.5 / PI));
        const double c = cos(angle), s = sin(angle), ia = c * d - s * q, ib = s * d + c * q;
        for (int leg = 0; leg < 3; leg++) sensed[leg] = of_phase(leg, ia, ib);
        const double driving = period[IMPULSE] / k->period - drag - k->viscous * speed;
        change = (driving - k->load - k->friction) * k->period / k->inertia;
        speed += change;
        memcpy(ratios[0], ratios[1], sizeof ratios[0]);
    }
    return worst;
}
