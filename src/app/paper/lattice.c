/* Measures the speed of sound in triangular lattices. */
#include "paper/lattice.h"

#include <math.h>

double sp_paper_lattice_speed(double p, double eta) {
    return pow(3, 19.0 / 12) / (pow(2, 1.5) * sqrt(3.14159265358979323846)) * sqrt(1 + eta / 3) * pow(p, 1.0 / 6);
}

/* Heights and arrival times in lattices of one kind, at most `most`. */
static int lattice_arrivals(const paper_set *set, bool friction, double p, int most, double *height, double *time) {
    const double lowest = set->n > 0 ? set->sample[set->n - 1].height / 5 : 0; /* leaves out the lattice of Fig. 12 */
    int n = 0;
    for (int64_t k = 0; k < set->n && n < most; k++) {
        const sp_sample *s = &set->sample[k];
        if ((s->friction > 0) != friction || fabs(s->pressure - p) > 1e-9 * p || !(s->have & SP_WANT_CTOF) ||
            s->height < lowest)
            continue;
        height[n] = s->height;
        time[n++] = s->front.t10;
    }
    return n;
}

double sp_paper_lattice_small(const paper *p, bool friction, double pressure) {
    double height[2], time[2];
    if (lattice_arrivals(&p->set[PAPER_LATTICE], friction, pressure, 2, height, time) < 2)
        return NAN;
    return (height[1] - height[0]) / (time[1] - time[0]);
}

double sp_paper_lattice_long(const paper *p, bool friction, double *between) {
    double h[3], t[3];
    if (lattice_arrivals(&p->set[PAPER_LATTICE_LONG], friction, 5e-7, 3, h, t) < 3)
        return *between = NAN;
    const double h10 = h[1] - h[0], h21 = h[2] - h[1], t10 = t[1] - t[0], t21 = t[2] - t[1],
                 r10 = cbrt(h[1]) - cbrt(h[0]), r21 = cbrt(h[2]) - cbrt(h[1]);
    *between = h21 / t21;
    return (h10 * r21 - h21 * r10) / (t10 * r21 - t21 * r10);
}
