/* One phase on its half-bridge leg, advanced exactly from event to event within a control period. */
#ifndef PHASE_H
#define PHASE_H

#include <stdint.h>

#include "leg.h"
#include "winding.h"

#define PI 3.141592653589793
#define EVENT_LIMIT 200000

/* Constants of the drive (SI units), in the order in which the caller lays them out. */
typedef struct {
    int64_t phases, pole_pairs;
    double resistance, inductance, emf_constant, half_supply_voltage, hysteresis_band, window, current_limit;
    double core_loss_conductance, inertia, friction, viscous_friction, switch_drop, diode_drop;
    double turn_on_energy, turn_off_energy;
    int64_t pieces; /* straight pieces of the back-EMF over a cycle */
    const double *emf_angles, *emf_values, *emf_slopes;
} drive;

/* Exact integrals over all phases; `peak` is a maximum. */
typedef struct {
    double magnitude, square, impulse, upper, lower, exchanged, returned, device, switching;
    double core_source, core_drag_impulse, peak, events;
} ledger;

typedef struct {
    double current;
    int sector, latch;
} phase;

/* What is constant within a control period. */
typedef struct {
    double speed, upper, lower, reference, advance, duration;
} period_inputs;

static inline double wrapped(double angle) { return most(angle - 2.0 * PI * floor(angle * (0.5 / PI)), 0.0); }

static inline int compared(int latch, double magnitude, double reference, double band) {
    if (magnitude >= reference + band) return 0;
    if (magnitude <= most(reference - band, 0.0)) return 1;
    return latch;
}

/* Sector at an advanced angle; writes the angle to its end and the sign of the next window. */
static inline int window_state(double angle, double window, double *to_edge, int *next) {
    double position = wrapped(angle - 0.5 * (PI - window));
    *next = position < PI ? -1 : 1;
    if (position < window) {
        *to_edge = window - position;
        return 1;
    }
    if (position < PI) {
        *to_edge = PI - position;
        return 0;
    }
    if (position < PI + window) {
        *to_edge = PI + window - position;
        return -1;
    }
    *to_edge = 2.0 * PI - position;
    return 0;
}

static inline int64_t corner_before(const double *corners, int64_t pieces, double angle) {
    int64_t low = 0, high = pieces;
    while (high - low > 1) {
        int64_t middle = (low + high) / 2;
        if (corners[middle] <= angle)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Advance a phase by a control period and add to the ledger; false when it switches without end. */
static inline bool advance_phase(const drive *d, phase *p, double angle, const period_inputs *in, ledger *total) {
    const double resistance = d->resistance;
    const double inverse_inductance = 1.0 / d->inductance;
    const double rate = resistance * inverse_inductance;
    const double band = d->hysteresis_band;
    const double duration = in->duration;
    double electrical = (double)d->pole_pairs * in->speed;
    if (electrical < 1e-100) electrical = 0.0;
    const double reference = in->reference < 1e-20 ? 0.0 : in->reference;
    const double emf_peak = d->emf_constant * in->speed;
    const rails r = {in->upper, in->lower, d->switch_drop, d->diode_drop};
    const double longest = rate > 0.0 ? LONGEST / rate : INFINITY;
    const double *corners = d->emf_angles;

    angle = wrapped(angle);
    int64_t corner = corner_before(corners, d->pieces, angle);
    const double per_radian = electrical > 0.0 ? 1.0 / electrical : INFINITY;
    double turn_base = -angle;
    double corner_time = electrical > 0.0 ? (corners[corner] + turn_base) * per_radian : 0.0;
    double next_corner_time = electrical > 0.0 ? (corners[corner + 1] + turn_base) * per_radian : INFINITY;
    double shape_start = d->emf_values[corner];
    double shape_rate = d->emf_slopes[corner] * electrical;
    if (electrical == 0.0) shape_start += d->emf_slopes[corner] * (angle - corners[corner]);

    double to_edge;
    int next_sector;
    int sector = window_state(angle + in->advance, d->window, &to_edge, &next_sector);
    double edge_time = electrical > 0.0 ? to_edge * per_radian : INFINITY;
    double current = p->current;
    int latch = p->latch;
    int gate_was = reference <= 0.0 ? 0 : p->sector * latch;
    if (sector != p->sector) latch = 1;
    if (sector != 0) latch = compared(latch, sector * current, reference, band);

    double time = 0.0, peak = fabs(current), shape_current = 0.0, core = 0.0, drag = 0.0;
    int depart = 0, conducting = 0, events = 0;
    ledger sum = {0};

    while (time < duration) {
        if (++events > EVENT_LIMIT) return false;
        const double shape = shape_start + shape_rate * (time - corner_time);
        const double emf = emf_peak * shape;
        const double emf_rate = emf_peak * shape_rate;
        const double front_source = sector > 0 ? r.upper : r.lower;
        const double back_source = sector > 0 ? r.lower : r.upper;

        bool slides = false;
        int gate = 0;
        if (sector != 0 && reference > 0.0) {
            if (band == 0.0)
                slides = ideal_latch(sector * current, reference, sector * emf + resistance * reference,
                                     front_source - r.switch_drop, -(back_source + r.diode_drop), &latch, &depart);
            gate = sector * latch;
        }
        if (gate != gate_was) {
            if (band > 0.0) {
                sum.switching += gate_was != 0 ? d->turn_off_energy : 0.0;
                sum.switching += gate != 0 ? d->turn_on_energy : 0.0;
            }
            gate_was = gate;
        }
        link to = {0, 0};
        if (!slides) to = connection(gate, current, conducting, emf, emf_rate, &r);
        const int from_rest = conducting;
        conducting = 0;

        const double limit = least(least(duration, next_corner_time), edge_time);
        double length = most(limit - time, 0.0);
        bool at_limit = true;

        if (slides) {
            const double front = front_source - r.switch_drop, back = back_source + r.diode_drop;
            const double needed = sector * emf + resistance * reference, needed_rate = sector * emf_rate;
            const double wait = time_to_pass(needed, needed_rate, -back, front);
            if (wait < length) {
                length = most(wait, 0.0);
                at_limit = false;
                depart = needed_rate > 0.0 ? -1 : 1;
            }
            if (length > 0.0) {
                /* The switch's share of time, the limit of a band that shrinks to nothing. */
                const double share = (needed + 0.5 * needed_rate * length + back) / (front + back);
                const double charge = reference * length;
                const double taken = share * front_source * charge, given = (1.0 - share) * back_source * charge;
                const double drop = resistance * reference;
                sum.magnitude += charge;
                sum.square += reference * charge;
                shape_current += sector * (shape + 0.5 * shape_rate * length) * charge;
                sum.upper += sector > 0 ? taken : -given;
                sum.lower += sector > 0 ? -given : taken;
                sum.exchanged += taken + given;
                sum.returned += given;
                sum.device += (share * r.switch_drop + (1.0 - share) * r.diode_drop) * charge;
                core += (share * (front - drop) * (front - drop) + (1.0 - share) * (back + drop) * (back + drop)) * length;
            }
        } else if (to.rail == 0) {
            /* Until the back-EMF passes a rail (or leaves the dead zone of a closed switch). */
            const double high = gate >= 0 ? r.upper + r.diode_drop : -(r.lower - r.switch_drop);
            const double low = gate <= 0 ? -(r.lower + r.diode_drop) : r.upper - r.switch_drop;
            const double wait = time_to_pass(emf, emf_rate, low, high);
            if (wait < length) {
                length = most(wait, 0.0);
                at_limit = false;
                conducting = emf_rate > 0.0 ? -1 : 1;
            }
            if (length > 0.0)
                drag += length * (shape * shape + shape_rate * length * (shape + shape_rate * length / 3.0));
        } else {
            if (length > longest) {
                length = longest;
                at_limit = false;
            }
            const double source = to.rail > 0 ? r.upper : r.lower;
            const bool returning = to.rail * to.side < 0;
            const double voltage = to.rail * (returning ? source + r.diode_drop : source - r.switch_drop);
            stretch s = {current, (voltage - emf - resistance * current) * inverse_inductance,
                         emf_rate * inverse_inductance, rate};
            /* Leaving rest or a slide: what is left of the slope is rounding. */
            if (from_rest != 0 || (current == 0.0 && to.side * s.slope < 0.0) || depart * sector * s.slope < 0.0)
                s.slope = 0.0;
            depart = 0;
            const moment at_end = current_after(&s, length);

            const double zero_time = crossing_time(&s, length, at_end, 0.0, to.side < 0);
            double level = 0.0, level_time = INFINITY;
            if (gate != 0) {
                if (to.side == gate) {
                    level = gate * (reference + band);
                    level_time = crossing_time(&s, length, at_end, level, gate > 0);
                }
            } else if (sector != 0 && reference > 0.0 && to.side == sector) {
                level = sector * most(reference - band, 0.0);
                if (level != 0.0) level_time = crossing_time(&s, length, at_end, level, sector < 0);
            }
            const bool at_level = level_time <= zero_time && level_time <= length;
            const bool at_zero = !at_level && zero_time <= length;
            if (at_level || at_zero) {
                length = at_level ? level_time : zero_time;
                at_limit = false;
            }
            if (length > 0.0) {
                const integrals part = integrate(&s, length);
                if (s.slope * part.end.slope < 0.0)
                    peak = most(peak, fabs(current_after(&s, turning_time(&s)).current));
                const double magnitude = to.side * part.first;
                sum.magnitude += magnitude;
                sum.square += part.square;
                shape_current += (shape + shape_rate * length) * part.first - shape_rate * part.second;
                const double energy = to.rail * source * part.first;
                if (to.rail > 0)
                    sum.upper += energy;
                else
                    sum.lower += energy;
                sum.exchanged += source * magnitude;
                if (returning) sum.returned += source * magnitude;
                sum.device += (returning ? r.diode_drop : r.switch_drop) * magnitude;
                core += voltage * (voltage * length - 2.0 * resistance * part.first);
                core += resistance * resistance * part.square;
                current = part.end.current;
            }
            if (at_level) {
                current = level;
                latch = gate == 0;
            } else if (at_zero) {
                current = 0.0;
                /* The comparator's lower edge is at zero. */
                if (gate == 0 && to.side == sector && 0.0 < reference && reference <= band) latch = 1;
            }
            peak = most(peak, fabs(current));
        }

        if (at_limit)
            time = limit;
        else
            time += length;
        while (time >= next_corner_time) {
            if (++corner == d->pieces) {
                corner = 0;
                turn_base += 2.0 * PI;
            }
            corner_time = (corners[corner] + turn_base) * per_radian;
            next_corner_time = (corners[corner + 1] + turn_base) * per_radian;
            shape_start = d->emf_values[corner];
            shape_rate = d->emf_slopes[corner] * electrical;
        }
        while (time >= edge_time) {
            if (sector != 0) {
                next_sector = -sector;
                sector = 0;
                edge_time += (PI - d->window) * per_radian;
            } else {
                sector = next_sector;
                latch = compared(1, sector * current, reference, band);
                edge_time += d->window * per_radian;
            }
            depart = 0;
        }
    }

    p->current = current;
    p->sector = sector;
    p->latch = latch;
    total->magnitude += sum.magnitude;
    total->square += sum.square;
    total->impulse += d->emf_constant * shape_current;
    total->upper += sum.upper;
    total->lower += sum.lower;
    total->exchanged += sum.exchanged;
    total->returned += sum.returned;
    total->device += sum.device;
    total->switching += sum.switching;
    total->core_source += d->core_loss_conductance * core;
    total->core_drag_impulse += d->core_loss_conductance * d->emf_constant * emf_peak * drag;
    total->peak = most(total->peak, peak);
    total->events += events;
    return true;
}

#endif
