/* A period in which no current comes to zero, all of its segments at once: each is an affine map of the currents, whose
 * power series have the coefficients of the period. */
enum { ROOM = 8, ORDERS = 9 };
/* Segments over the time of the fastest rate up to which six orders will do; eight do in all. */
#define SIX_ORDERS 0.0125

typedef struct {
    int count;
    double longest, time[ROOM + 1], along[ROOM], across[ROOM], link_along[ROOM], link_across[ROOM];
    double d[ROOM + 1], q[ROOM + 1], cosine[ROOM + 1], sine[ROOM + 1];
    double dd[ROOM], dq[ROOM], da[ROOM], qq[ROOM], qd[ROOM], qa[ROOM];
    double square[ROOM], torque[ROOM], charge_along[ROOM], charge_across[ROOM];
} segments;

typedef struct { double even, odd, dd, dq, qd, qq, od, oq, turned; } orders;

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
    for (int n = s->count; n <= ROOM; n++) s->time[n] = k->period;
    for (int n = s->count; n < ROOM; n++) s->along[n] = s->across[n] = 0.0;
}

static inline orders following(const rates *r, double m, double square, const orders *b, int order) {
    const double share = 1.0 / order, straight = order % 2 ? b->turned : 0.0, turning = order % 2 ? 0.0 : b->turned;
    return (orders){share * (m * b->even + square * b->odd), share * (m * b->odd + b->even),
                    share * (r->dd * b->dd + r->dq * b->qd + straight), share * (r->dd * b->dq + r->dq * (b->qq + turning)),
                    share * (r->qq * b->qd + r->qd * (b->dd + turning)), share * (r->qq * b->qq + r->qd * b->dq + straight),
                    share * (r->dd * b->od + r->dq * b->oq), share * (r->qd * b->od + r->qq * b->oq),
                    share * (order % 2 ? b->turned : b->turned * r->dq * r->qd)};
}

#define SUM(field) sum(last, h, o[1].field, o[2].field, o[3].field, o[4].field, o[5].field, o[6].field, o[7].field, o[8].field)
static inline double sum(int last, double h, double a, double b, double c, double d, double e, double f, double g, double i) {
    const double tail = last == 6 ? f : f + h * (g + h * i);
    return h * (a + h * (b + h * (c + h * (d + h * (e + h * tail)))));
}

static inline void propagate(const rates *r, const frame *f, segments *s, const int last) {
    const double m = 0.5 * (r->dd + r->qq), half = 0.5 * (r->dd - r->qq), square = half * half + r->dq * r->qd;
    orders o[ORDERS] = {0};
    o[1] = (orders){m, 1, 1, 0, 0, 1, 0, -r->opposed, 1};
    for (int order = 2; order <= last; order++) o[order] = following(r, m, square, &o[order - 1], order);
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
        s->da[n] = SUM(dd) * vd + SUM(dq) * vq + SUM(od);
        s->qa[n] = SUM(qd) * vd + SUM(qq) * vq + SUM(oq);
    }
    turn_by(f, r->w * s->time[s->count], &s->cosine[s->count], &s->sine[s->count]);
    double d = f->d, q = f->q;
    s->d[0] = d;
    s->q[0] = q;
    for (int n = 0; n < s->count; n++) {
        const double gained = s->dd[n] * d + s->dq[n] * q + s->da[n];
        q += s->qd[n] * d + s->qq[n] * q + s->qa[n];
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

static inline double slope_at(const segments *s, int at, const currents *c, int leg) {
    const double C = s->cosine[at], S = s->sine[at];
    return of_phase(leg, C * c->d.slope - S * c->q.slope, S * c->d.slope + C * c->q.slope);
}

/* The greatest magnitude of a phase current, below 0 where one may come to zero. */
static double peak_of(const rates *r, const segments *s) {
    double current[3][ROOM + 1], peak = 0.0, top[3] = {0.0};
    const double deviation = 0.125 * r->bend * s->longest * s->longest;
    for (int leg = 0; leg < 3; leg++) {
        double low = INFINITY, high = -INFINITY;
        for (int n = 0; n <= s->count; n++) {
            const double C = s->cosine[n], S = s->sine[n];
            const double i = of_phase(leg, C * s->d[n] - S * s->q[n], S * s->d[n] + C * s->q[n]);
            current[leg][n] = i;
            low = fmin(low, i);
            high = fmax(high, i);
        }
        if (low <= deviation && -high <= deviation) return -1.0;
        top[leg] = fmax(high, -low);
        peak = fmax(peak, top[leg]);
    }
    const double most = peak - deviation;
    for (int leg = 0; leg < 3; leg++)
        for (int n = 0; n < s->count && top[leg] > most; n++) {
            if (fmax(fabs(current[leg][n]), fabs(current[leg][n + 1])) <= most) continue;
            const currents begin = currents_at(r, s, n, n), end = currents_at(r, s, n + 1, n);
            const currents b = standing(&begin, r->w), e = standing(&end, r->w);
            const double h = s->time[n + 1] - s->time[n], change = change_of(r, &b, h);
            const double bs = slope_at(s, n, &b, leg), es = slope_at(s, n + 1, &e, leg);
            if (bs * es < 0.0 && !(fmin(bs, es) > change || fmax(bs, es) < -change)) {
                const frame f = {s->d[n], s->q[n], s->cosine[n], s->sine[n]};
                const double vd = r->per_d * (f.cosine * s->along[n] + f.sine * s->across[n]);
                const double vq = r->per_q * (f.cosine * s->across[n] - f.sine * s->along[n]);
                const double at = zero_of(r, &begin, &f, vd, vq, h, leg, 1);
                peak = fmax(peak, fabs(phase_at(r, &begin, &f, vd, vq, at, leg).value));
            }
        }
    return peak;
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

/* Pass a whole period, if no current comes to zero in it, and add it to the ledger; tell whether it has been passed. */
static int pass_period(const task *k, const rates *r, frame *f, const double edge[3][2], double *totals) {
    segments s;
    lay_out(k, edge, &s);
    const double reach = r->rate * s.longest;
    if (reach > SHORT) return 0;
    if (reach <= SIX_ORDERS) propagate(r, f, &s, 6);
    else propagate(r, f, &s, 8);
    const double peak = peak_of(r, &s);
    if (peak < 0.0) return 0;
    totals[PEAK] = fmax(totals[PEAK], peak);
    for (int n = s.count; n < ROOM; n++) s.d[n + 1] = s.q[n + 1] = s.cosine[n + 1] = s.sine[n + 1] = 0.0;
    if (reach <= SHORTEST) integrate(k, r, &s, 1);
    else integrate(k, r, &s, 0);
    double square = 0.0, torque = 0.0, along = 0.0, across = 0.0, taken = 0.0, exchanged = 0.0;
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
    for (int leg = 0; leg < 3; leg++) totals[MAGNITUDE] += fabs(of_phase(leg, along, across));
    totals[EVENTS] += s.count;
    *f = (frame){s.d[s.count], s.q[s.count], s.cosine[s.count], s.sine[s.count]};
    return 1;
}
