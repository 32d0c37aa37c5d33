/* The columns of the paper, and quantities that several items derive from them. */
#include "paper/blackmore.h"

sp_tapped_spec sp_blackmore_column(int32_t particles) {
    sp_tapped_spec c = sp_tapped_spec_default();
    c.particles = particles;
    c.frequency = particles == 10 ? 9.5 : 7.5;
    c.taps = 4;
    return c;
}

double sp_blackmore_overlap(const sp_tapped_spec *c) {
    return sp_tapped_mass(c, 1) * c->gravity / sp_tapped_stiffness(c);
}

double sp_blackmore_speed2(const sp_tapped_spec *c) {
    const double h = 2 * sp_tapped_radius(c, 1);
    return sp_tapped_stiffness(c) * h * h / sp_tapped_mass(c, 1);
}

double sp_blackmore_separation(const sp_tapped_report *report) {
    double least = INFINITY;
    for (int32_t k = 0; k < report->taps; k++)
        least = fmin(least, report->tap[k].separation);
    return least;
}

blackmore_coefficients sp_blackmore_coefficients(double r, double alpha) {
    const double cubed = 16 * pow(r * alpha, 3);
    return (blackmore_coefficients){.plus = 1.5 + 6 * r * alpha - cubed,
                                    .minus = 1.5 + 6 * r * alpha + cubed,
                                    .b = alpha * (1 - 8 * r * r * alpha * alpha)};
}
