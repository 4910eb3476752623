/* A period all of whose segments go at once: each is an affine map of the currents, whose power series have the
 * coefficients of the period. The magnitude of a current that passes zero is divided there. */
enum { CAPACITY = 8, ORDERS = 9 };
/* Segments over the time of the fastest rate up to which six orders will do; eight do in all. */
#define SIX_ORDERS 0.0125

typedef struct {
    int count;
    double longest, time[CAPACITY + 1], along[CAPACITY], across[CAPACITY], link_along[CAPACITY], link_across[CAPACITY];
    double d[CAPACITY + 1], q[CAPACITY + 1], cosine[CAPACITY + 1], sine[CAPACITY + 1];
    double dd[CAPACITY], dq[CAPACITY], da[CAPACITY], qq[CAPACITY], qd[CAPACITY], qa[CAPACITY];
    double square[CAPACITY], torque[CAPACITY], charge_along[CAPACITY], charge_across[CAPACITY];
} segments;

/* An order of the growth without a voltage, and of what voltages make of no current. */
typedef struct { double even, odd; } orders;
typedef struct { double d, q, vd, vq; } step;

static inline void small_turn(double a, double *co, double *si) {
    const double s = a * a;
    *co = 1 - s * (0.5 - s * (1.0 / 24 - s * (1.0 / 720 - s * (1.0 / 40320 - s * (1.0 / 3628800)))));
    *si = a * (1 - s * (1.0 / 6 - s * (1.0 / 120 - s * (1.0 / 5040 - s * (1.0 / 362880 - s * (1.0 / 39916800))))));
}

static inline void turn_by(const frame *f, double a, double *cosine, double *sine) {
    double co, si;
    small_turn(a, &co, &si);
    *cosine = f->cosine * co - f->sine * si;
    *sine = f->sine * co + f->cosine * si;
}

static void lay_out(const task *k, const double edge[3][2], segments *s) {
    int upper[3];
    double next[3];
    for (int leg = 0; leg < 3; leg++) {
        upper[leg] = edge[leg][0] <= 0.0 && edge[leg][1] > 0.0;
        next[leg] = upper[leg] ? edge[leg][1] : edge[leg][0] > 0.0 && edge[leg][0] < edge[leg][1] ? edge[leg][0] : k->period;
    }
    s->count = 0;
    s->longest = 0.0;
    for (double time = 0.0; time < k->period;) {
        const int n = s->count++;
        const double u = upper[0], v = upper[1], w = upper[2];
        s->time[n] = time;
        s->along[n] = k->link * (2 * u - v - w) * (1.0 / 3.0);
        s->across[n] = k->link * (v - w) * (0.5 / HALF_ROOT);
        s->link_along[n] = u - 0.5 * (v + w);
        s->link_across[n] = HALF_ROOT * (v - w);
        const double limit = fmin(fmin(next[0], next[1]), next[2]);
        s->longest = fmax(s->longest, limit - time);
        for (int leg = 0; leg < 3; leg++)
            if (next[leg] <= limit && limit < k->period) {
                upper[leg] = !upper[leg];
                next[leg] = upper[leg] ? edge[leg][1] : k->period;
            }
        time = limit;
    }
    for (int n = s->count; n <= CAPACITY; n++) s->time[n] = k->period;
    for (int n = s->count; n < CAPACITY; n++) s->along[n] = s->across[n] = 0.0;
}

static inline step following(const rates *r, double h, step b, int order) {
    const double share = h * (1.0 / order), turned = r->dq * b.vq, across = r->qd * b.vd;
    return (step){share * (r->dd * b.d + r->dq * b.q + turned), share * (r->qd * b.d + r->qq * b.q + across), share * turned,
                  share * across};
}

static inline void added(const rates *r, double h, double vd, double vq, int last, double *d, double *q) {
    const step x1 = {h * vd, h * (vq - r->opposed), h * vd, h * vq}, x2 = following(r, h, x1, 2), x3 = following(r, h, x2, 3),
               x4 = following(r, h, x3, 4), x5 = following(r, h, x4, 5), x6 = following(r, h, x5, 6);
    double rest = x6.d, across = x6.q;
    if (last > 6) {
        const step x7 = following(r, h, x6, 7), x8 = following(r, h, x7, 8);
        rest += x7.d + x8.d;
        across += x7.q + x8.q;
    }
    *d = x1.d + (x2.d + (x3.d + (x4.d + (x5.d + rest))));
    *q = x1.q + (x2.q + (x3.q + (x4.q + (x5.q + across))));
}

#define SUM(field) sum(last, h, o[1].field, o[2].field, o[3].field, o[4].field, o[5].field, o[6].field, o[7].field, o[8].field)
static inline double sum(int last, double h, double a, double b, double c, double d, double e, double f, double g, double i) {
    const double tail = last == 6 ? f : f + h * (g + h * i);
    return h * (a + h * (b + h * (c + h * (d + h * (e + h * tail)))));
}

static inline void propagate(const rates *r, const frame *f, segments *s, const int last) {
    const double m = 0.5 * (r->dd + r->qq), half = 0.5 * (r->dd - r->qq), square = half * half + r->dq * r->qd;
    orders o[ORDERS] = {0};
    o[1] = (orders){m, 1};
    for (int k = 2; k <= last; k++)
        o[k] = (orders){(m * o[k - 1].even + square * o[k - 1].odd) * (1.0 / k), (m * o[k - 1].odd + o[k - 1].even) * (1.0 / k)};
    const int groups = (s->count + 3) / 4 * 4;
    for (int n = 0; n < groups; n++) {
        const double h = s->time[n + 1] - s->time[n];
        double C, S;
        turn_by(f, r->w * s->time[n], &C, &S);
        const double vd = r->per_d * (C * s->along[n] + S * s->across[n]), vq = r->per_q * (C * s->across[n] - S * s->along[n]);
        const double even = SUM(even), odd = SUM(odd);
        s->cosine[n] = C;
        s->sine[n] = S;
        s->dd[n] = even + half * odd;
        s->dq[n] = r->dq * odd;
        s->qd[n] = r->qd * odd;
        s->qq[n] = even - half * odd;
        added(r, h, vd, vq, last, &s->da[n], &s->qa[n]);
    }
    turn_by(f, r->w * s->time[s->count], &s->cosine[s->count], &s->sine[s->count]);
    double d = f->d, q = f->q;
    s->d[0] = d;
    s->q[0] = q;
    for (int n = 0; n < s->count; n++) {
        const double gained = s->dd[n] * d + (s->dq[n] * q + s->da[n]);
        q += s->qq[n] * q + (s->qd[n] * d + s->qa[n]);
        d += gained;
        s->d[n + 1] = d;
        s->q[n + 1] = q;
    }
}

static inline currents currents_at(const rates *r, const segments *s, int at, int n) {
    const double C = s->cosine[at], S = s->sine[at];
    return derivatives(r, s->d[at], s->q[at], r->per_d * (C * s->along[n] + S * s->across[n]),
                       r->per_q * (C * s->across[n] - S * s->along[n]));
}

static inline jet jet_of(const segments *s, int at, const currents *c, int leg) {
    const double C = s->cosine[at], S = s->sine[at];
    const jet d = c->d, q = c->q;
    return (jet){of_phase(leg, C * d.value - S * q.value, S * d.value + C * q.value),
                 of_phase(leg, C * d.slope - S * q.slope, S * d.slope + C * q.slope),
                 of_phase(leg, C * d.bend - S * q.bend, S * d.bend + C * q.bend),
                 of_phase(leg, C * d.jerk - S * q.jerk, S * d.jerk + C * q.jerk)};
}

static inline void coefficients(double v, double s, double b, double j, double c[4]) {
    c[0] = v;
    c[1] = 4 * v + s;
    c[2] = 10 * v + 4 * s + b;
    c[3] = 20 * v + 10 * s + 4 * b + j;
}

/* The polynomial of degree 7 through value and three derivatives at both ends of a segment, at a share of it. */
static inline double interpolated(const double p[2][4], double x) {
    const double y = 1 - x, x2 = x * x, y2 = y * y, *b = p[0], *e = p[1];
    return y2 * y2 * (b[0] + x * (b[1] + x * (b[2] + x * b[3]))) + x2 * x2 * (e[0] + y * (e[1] + y * (e[2] + y * e[3])));
}

static inline void interpolate(const jet *b, const jet *e, double h, double p[2][4]) {
    const double half = 0.5 * h * h, sixth = (1.0 / 3.0) * h * half;
    coefficients(b->value, h * b->slope, half * b->bend, sixth * b->jerk, p[0]);
    coefficients(e->value, -h * e->slope, half * e->bend, -sixth * e->jerk, p[1]);
}

static inline double interpolated_slope(const jet *b, const jet *e, double h, double x) {
    const double y = 1 - x;
    return y * y * (b->slope + x * (2 * b->slope + h * b->bend)) + x * x * (e->slope + y * (2 * e->slope - h * e->bend));
}

/* A phase current where its slope, of opposite signs at both ends, is zero. */
static double turning_value(const jet *b, const jet *e, double h) {
    double at = b->slope / (b->slope - e->slope), p[2][4];
    for (int k = 0; k < 14; k++) {
        const double step = interpolated_slope(b, e, h, at) / (h * (b->bend + at * (e->bend - b->bend)));
        at = fmin(fmax(at - step, 0.0), 1.0);
        if (fabs(step) < 1e-8) break;
    }
    interpolate(b, e, h, p);
    return interpolated(p, at);
}

/* The phase currents at the ends of segments, and which of them keep their signs. */
typedef struct { double at[3][CAPACITY + 1], top[3]; int keeps[3]; } ends;

static ends ends_of(const rates *r, const segments *s) {
    ends all = {0};
    const double deviation = 0.125 * r->bend * s->longest * s->longest;
    for (int leg = 0; leg < 3; leg++) {
        double low = INFINITY, high = -INFINITY;
        for (int n = 0; n <= s->count; n++) {
            const double C = s->cosine[n], S = s->sine[n];
            const double i = of_phase(leg, C * s->d[n] - S * s->q[n], S * s->d[n] + C * s->q[n]);
            all.at[leg][n] = i;
            low = fmin(low, i);
            high = fmax(high, i);
        }
        all.keeps[leg] = low > deviation || -high > deviation;
        all.top[leg] = fmax(high, -low);
    }
    return all;
}

/* The greatest magnitude of a phase current. */
static double peak_of(const rates *r, const segments *s, const ends *c) {
    double peak = fmax(fmax(c->top[0], c->top[1]), c->top[2]);
    const double least = peak - 0.125 * r->bend * s->longest * s->longest;
    for (int leg = 0; leg < 3; leg++)
        for (int n = 0; n < s->count && c->top[leg] > least; n++) {
            const double before = c->at[leg][n], behind = c->at[leg][n + 1];
            const double h = s->time[n + 1] - s->time[n], sagitta = 0.125 * r->bend * h * h;
            if (fmax(fabs(before), fabs(behind)) + sagitta <= peak || fabs(behind - before) > 4 * sagitta) continue;
            const currents begin = currents_at(r, s, n, n), end = currents_at(r, s, n + 1, n);
            const currents bs = standing(&begin, r->w), es = standing(&end, r->w);
            const jet b = jet_of(s, n, &bs, leg), e = jet_of(s, n + 1, &es, leg);
            if (b.slope * e.slope < 0.0) peak = fmax(peak, fabs(turning_value(&b, &e, h)));
        }
    return peak;
}

/* Integral of a phase current that only rises or only falls up to its zero. */
static double charge_to_zero(const jet *b, const jet *e, double h) {
    static const double place[4] = {0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262};
    static const double weight[4] = {0.17392742256872679, 0.3260725774312732, 0.3260725774312732, 0.17392742256872679};
    double p[2][4], low = 0.0, high = 1.0, at = b->value / (b->value - e->value), sum = 0.0;
    interpolate(b, e, h, p);
    for (int k = 0; k < 60; k++) {
        const double value = interpolated(p, at);
        if (b->value > 0.0 ? value > 0.0 : value < 0.0) low = at; else high = at;
        double next = at - value / (h * interpolated_slope(b, e, h, at));
        if (!(low <= next && next <= high)) next = 0.5 * (low + high);
        const double step = fabs(next - at);
        at = next;
        if (step < 1e-9) break;
    }
    for (int n = 0; n < 4; n++) sum += weight[n] * interpolated(p, at * place[n]);
    return h * at * sum;
}

/* Whether a current that comes near zero only rises or only falls in every segment there. */
static int passes_zero(const rates *r, const segments *s, const ends *c, int leg) {
    for (int n = 0; n < s->count; n++) {
        const double before = c->at[leg][n], behind = c->at[leg][n + 1], h = s->time[n + 1] - s->time[n];
        const double sagitta = 0.125 * r->bend * h * h;
        if (before * behind >= 0.0 && fmin(fabs(before), fabs(behind)) > sagitta) continue;
        if (fabs(behind - before) > 4 * sagitta) continue;
        const currents begin = currents_at(r, s, n, n), end = currents_at(r, s, n + 1, n);
        const currents bs = standing(&begin, r->w), es = standing(&end, r->w);
        const double b = jet_of(s, n, &bs, leg).slope, e = jet_of(s, n + 1, &es, leg).slope, change = change_of(r, &bs, h);
        if (fmin(b, e) <= change && fmax(b, e) >= -change) return 0;
    }
    return 1;
}

/* Integral of a current's magnitude beyond the magnitude of its integral, and what the link exchanges beyond that of each
 * segment. */
static double returning(const rates *r, const segments *s, const ends *c, int leg, double *exchanged) {
    double magnitude = 0.0, whole = 0.0;
    for (int n = 0; n < s->count; n++) {
        const double charge = of_phase(leg, s->charge_along[n], s->charge_across[n]);
        double parts = fabs(charge);
        if (c->at[leg][n] * c->at[leg][n + 1] < 0.0) {
            const currents begin = currents_at(r, s, n, n), end = currents_at(r, s, n + 1, n);
            const currents bs = standing(&begin, r->w), es = standing(&end, r->w);
            const jet b = jet_of(s, n, &bs, leg), e = jet_of(s, n + 1, &es, leg);
            const double first = charge_to_zero(&b, &e, s->time[n + 1] - s->time[n]);
            parts = fabs(first) + fabs(charge - first);
            if (fabs(of_phase(leg, s->link_along[n], s->link_across[n])) > 0.75) *exchanged += parts - fabs(charge);
        }
        magnitude += parts;
        whole += charge;
    }
    return magnitude - fabs(whole);
}

static inline void integrate(const task *k, const rates *r, segments *s, int shortest) {
    const int groups = (s->count + 3) / 4 * 4;
    for (int n = 0; n < groups; n++) {
        const currents begin = currents_at(r, s, n, n), end = currents_at(r, s, n + 1, n);
        const frame f = {s->d[n], s->q[n], s->cosine[n], s->sine[n]};
        const frame after = {s->d[n + 1], s->q[n + 1], s->cosine[n + 1], s->sine[n + 1]};
        const sums all = sums_between(k, r, &begin, &end, &f, &after, s->time[n + 1] - s->time[n], shortest);
        s->square[n] = all.square;
        s->torque[n] = all.torque;
        s->charge_along[n] = all.along;
        s->charge_across[n] = all.across;
    }
}

/* Pass a whole period, if no current may turn near zero in it, and add it to the ledger; return whether it has been passed. */
static int pass_period(const task *k, const rates *r, frame *f, const double edge[3][2], double *totals) {
    segments s;
    lay_out(k, edge, &s);
    const double reach = r->rate * s.longest;
    if (reach > SHORT) return 0;
    if (reach <= SIX_ORDERS) propagate(r, f, &s, 6);
    else propagate(r, f, &s, 8);
    const ends c = ends_of(r, &s);
    for (int leg = 0; leg < 3; leg++)
        if (!c.keeps[leg] && !passes_zero(r, &s, &c, leg)) return 0;
    for (int n = s.count; n < CAPACITY; n++) s.d[n + 1] = s.q[n + 1] = s.cosine[n + 1] = s.sine[n + 1] = 0.0;
    if (reach <= SHORTEST) integrate(k, r, &s, 1);
    else integrate(k, r, &s, 0);
    double square = 0.0, torque = 0.0, along = 0.0, across = 0.0, taken = 0.0, exchanged = 0.0, beyond[3] = {0.0};
    for (int leg = 0; leg < 3; leg++)
        if (!c.keeps[leg]) beyond[leg] = returning(r, &s, &c, leg, &exchanged);
    totals[PEAK] = fmax(totals[PEAK], peak_of(r, &s, &c));
    for (int n = 0; n < s.count; n++) {
        const double charge = s.link_along[n] * s.charge_along[n] + s.link_across[n] * s.charge_across[n];
        square += s.square[n];
        torque += s.torque[n];
        along += s.charge_along[n];
        across += s.charge_across[n];
        taken += charge;
        exchanged += fabs(charge);
    }
    totals[SQUARE] += 1.5 * square;
    totals[IMPULSE] += 1.5 * k->pole_pairs * torque;
    totals[UPPER] += 0.5 * k->link * taken;
    totals[LOWER] += 0.5 * k->link * taken;
    totals[EXCHANGED] += k->link * exchanged;
    totals[RETURNED] += 0.5 * k->link * (exchanged - taken);
    for (int leg = 0; leg < 3; leg++) totals[MAGNITUDE] += fabs(of_phase(leg, along, across)) + beyond[leg];
    totals[EVENTS] += s.count;
    *f = (frame){s.d[s.count], s.q[s.count], s.cosine[s.count], s.sine[s.count]};
    return 1;
}
