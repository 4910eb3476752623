/* What a half-bridge leg connects its phase to: a rail, nothing, or the ideal regulator's slide along i*. */
#ifndef LEG_H
#define LEG_H

#include <math.h>
#include <stdbool.h>

/* Rail (1 upper, -1 lower, 0 floating) and the sign of the current until the next event. */
typedef struct {
    int rail, side;
} link;

/* The half-sources and the forward drops (V). */
typedef struct {
    double upper, lower, switch_drop, diode_drop;
} rails;

static inline link connection(int gate, double current, int starting, double emf, double emf_rate, const rails *r) {
    int side = current > 0.0 ? 1 : current < 0.0 ? -1 : starting;
    if (gate == 0) {
        if (side == 0) {
            /* Rectifying: the back-EMF drives current into a rail through that rail's diode. */
            double high = r->upper + r->diode_drop, low = -(r->lower + r->diode_drop);
            if (emf > high || (emf == high && emf_rate > 0.0))
                side = -1;
            else if (emf < low || (emf == low && emf_rate < 0.0))
                side = 1;
        }
        return (link){-side, side};
    }
    if (side == 0) {
        double source = gate > 0 ? r->upper : r->lower;
        double opposing = gate * emf;
        if (opposing < source - r->switch_drop)
            side = gate;
        else if (opposing > source + r->diode_drop)
            side = -gate;
        else if (r->switch_drop + r->diode_drop == 0.0)
            side = gate * emf_rate > 0.0 ? -gate : gate;
        else
            return (link){0, 0};
    }
    return (link){gate, side};
}

/* Time at which a straight line leaves a band; negative where it is outside already. */
static inline double time_to_pass(double value, double rate, double low, double high) {
    if (rate > 0.0) return (high - value) / rate;
    if (rate < 0.0) return (low - value) / rate;
    return 1e300;
}

/* The comparator without a band: returns whether the current is held at its reference, else sets the latch. */
static inline bool ideal_latch(double along, double reference, double needed, double front, double back, int *latch,
                               int *depart) {
    if (along != reference) {
        *latch = along < reference;
        return false;
    }
    if (*depart != 0) {
        *latch = *depart < 0;
        return false;
    }
    *latch = 1;
    if (needed > front) {
        *depart = -1;
        return false;
    }
    if (needed < back) {
        *depart = 1;
        *latch = 0;
        return false;
    }
    return true;
}

#endif
