/* The current of one winding between two events, in closed form; see docs/plant_theory.md. */
#ifndef WINDING_H
#define WINDING_H

#include <math.h>
#include <stdbool.h>

#include "series.h"

#define LONGEST 0.5 /* longest interval, as a multiple of L/R */

/* An interval without events, seen from its start: L di/dt = v - R i - e(t), with e a straight line. */
typedef struct {
    double start;     /* current (A) */
    double slope;     /* its slope (A/s) */
    double curvature; /* slope of the back-EMF over the inductance (A/s2) */
    double rate;      /* R/L (1/s) */
} stretch;

/* Current and its slope at one moment. */
typedef struct {
    double current, slope;
} moment;

/* What an interval adds: current and slope at its end, and integrals over it. */
typedef struct {
    moment end;
    double first, second, square;
} integrals;

static inline double least(double a, double b) { return b < a ? b : a; }
static inline double most(double a, double b) { return b > a ? b : a; }

static inline moment current_after(const stretch *s, double time) {
    double x = s->rate * time;
    double phi2 = 0.5 - x * (1.0 / 6.0 - x * series(PHI4, x));
    double phi1 = 1.0 - x * phi2;
    return (moment){
        s->start + time * (s->slope * phi1 - s->curvature * time * phi2),
        s->slope * (1.0 - x * phi1) - s->curvature * time * phi1,
    };
}

/* Time at which the slope passes zero, or infinity. */
static inline double turning_time(const stretch *s) {
    if (s->slope == 0.0 || s->curvature == 0.0 || (s->slope > 0.0) != (s->curvature > 0.0)) return INFINITY;
    double ratio = s->slope / s->curvature;
    double x = s->rate * ratio;
    if (x < 1e-9) return ratio * (1.0 - 0.5 * x);
    return log1p(x) / s->rate;
}

/* Root of i(t) = level within [low, high], where the current is monotone. */
static double root(const stretch *s, double level, double low, double high, bool rising) {
    double sign = rising ? 1.0 : -1.0;
    double low_limit = low, high_limit = high;
    double gap = level - s->start;
    double bending = s->curvature + s->rate * s->slope;
    double discriminant = s->slope * s->slope - 2.0 * bending * gap;
    double time = 0.5 * (low + high);
    if (discriminant >= 0.0) {
        /* The parabola that leaves the start with the current's slope and curvature. */
        double square = sqrt(discriminant);
        double divisor = s->slope + (s->slope >= 0.0 ? square : -square);
        double first = divisor != 0.0 ? 2.0 * gap / divisor : -1.0;
        double second = bending != 0.0 ? divisor / bending : -1.0;
        if (low <= first && first <= high)
            time = first;
        else if (low <= second && second <= high)
            time = second;
    }
    for (int turn = 0; turn < 200; turn++) {
        moment now = current_after(s, time);
        double error = now.current - level;
        if (error == 0.0) return time;
        if (sign * error > 0.0)
            high_limit = time;
        else
            low_limit = time;
        double step = now.slope != 0.0 ? error / now.slope : INFINITY;
        /* Newton's next error is this step times the share by which the slope changes over it. */
        double bend = (fabs(s->curvature) + s->rate * fabs(now.slope)) * fabs(step);
        if (fabs(step) * bend <= 2e-16 * high * fabs(now.slope) || fabs(step) <= 2e-16 * high)
            return least(most(time - step, low), high);
        double following = time - step;
        if (!(low_limit < following && following < high_limit)) {
            following = 0.5 * (low_limit + high_limit);
            if (following == low_limit || following == high_limit) return high_limit;
        }
        time = following;
    }
    return time;
}

/* First time in (0, end] at which the current reaches a level from one side, or infinity. */
static inline double crossing_time(const stretch *s, double end, moment at_end, double level, bool rising) {
    double sign = rising ? 1.0 : -1.0;
    bool approaching = sign * s->slope > 0.0 || (s->slope == 0.0 && sign * s->curvature < 0.0);
    bool reached_at_end = sign * (at_end.current - level) >= 0.0;
    if (approaching) {
        if (s->start == level) return 0.0;
        if (sign * at_end.slope >= 0.0) return reached_at_end ? root(s, level, 0.0, end, rising) : INFINITY;
        double turn = least(turning_time(s), end);
        if (!reached_at_end && sign * (current_after(s, turn).current - level) < 0.0) return INFINITY;
        return root(s, level, 0.0, turn, rising);
    }
    if (!reached_at_end) return INFINITY;
    double turn = turning_time(s);
    if (turn >= end) return s->start != level ? end : INFINITY;
    return root(s, level, turn, end, rising);
}

static inline integrals integrate(const stretch *s, double time) {
    double x = s->rate * time;
    double p4 = series(PHI4, x);
    double p3 = 1.0 / 6.0 - x * p4;
    double p2 = 0.5 - x * p3;
    double p1 = 1.0 - x * p2;
    double rise = s->slope * time;
    double bend = s->curvature * time * time;
    return (integrals){
        .end = {s->start + rise * p1 - bend * p2, s->slope * (1.0 - x * p1) - s->curvature * time * p1},
        .first = time * (s->start + rise * p2 - bend * p3),
        .second = time * time * (0.5 * s->start + rise * p3 - bend * p4),
        .square = time * (s->start * (s->start + 2.0 * (rise * p2 - bend * p3)) +
                          rise * (rise * series(SQUARE_11, x) - 2.0 * bend * series(SQUARE_12, x)) +
                          bend * bend * series(SQUARE_22, x)),
    };
}

#endif
