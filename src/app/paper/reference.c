/* Holds the numbers of Tables I, II, IV and V of Somfai, Roux, Snoeijer, van Hecke, van Saarloos, Phys. Rev. E 72,
 * 021301 (2005): means and one standard deviation of 30 samples of 600 grains, mu = 0.5, nu = 0. */
#include "paper/reference.h"

const double sp_paper_pressure[PAPER_PRESSURES] = {1e-7, 1e-6, 1e-5, 1e-4};

#define STATICS(member)                                                                                                \
    static double ours_##member(const sp_sample *s) { return s->statics.member; }
#define MODULI(member)                                                                                                 \
    static double ours_##member(const sp_sample *s) { return s->moduli.member; }
#define PROBE(member, row, which, over)                                                                                \
    static double ours_##member(const sp_sample *s) { return s->probe[row].which / s->moduli.over; }

STATICS(phi2)
STATICS(phi3)
STATICS(phi3s)
STATICS(zs)
STATICS(f0)
STATICS(n_over_p)
STATICS(z2)
STATICS(z3)
STATICS(f2)
STATICS(f2s)
STATICS(s1_over_s2)
MODULI(c11)
MODULI(c12)
MODULI(c22)
MODULI(c33)
PROBE(sine1_22, SP_SINE_1, along, c22)
PROBE(sine2_22, SP_SINE_2, along, c22)
PROBE(sine1_33, SP_SINE_1, shear, c33)
PROBE(sine2_33, SP_SINE_2, shear, c33)
PROBE(lines1_22, SP_LINES_1, along, c22)
PROBE(lines3_22, SP_LINES_3, along, c22)
PROBE(lines1_33, SP_LINES_1, shear, c33)
PROBE(lines3_33, SP_LINES_3, shear, c33)

#define D(digit)                                                                                                       \
    { digit, digit, digit, digit }

enum {
    S = SP_WANT_STATICS,
    M = SP_WANT_STATICS | SP_WANT_MODULI,
    P = SP_WANT_STATICS | SP_WANT_MODULI | SP_WANT_PROBES
};

/* clang-format off */
const paper_quantity sp_paper_quantities[] = {
    {PAPER_TABLE_1, "Phi2", S, ours_phi2, {0.818, 0.814, 0.809, 0.815}, {0.005, 0.004, 0.004, 0.005}, D(0.001)},
    {PAPER_TABLE_1, "Phi3", S, ours_phi3, {0.561, 0.558, 0.554, 0.558}, {0.005, 0.005, 0.005, 0.005}, D(0.001)},
    {PAPER_TABLE_1, "Phi3s", S, ours_phi3s, {0.48, 0.49, 0.50, 0.52}, {0.01, 0.01, 0.01, 0.01}, D(0.01)},
    {PAPER_TABLE_1, "zs", S, ours_zs, {3.18, 3.23, 3.31, 3.48}, {0.03, 0.04, 0.03, 0.03}, D(0.01)},
    {PAPER_TABLE_1, "f0", S, ours_f0, {15, 14, 11, 7.4}, {2, 2, 2, 1.5}, {1, 1, 1, 0.1}},
    {PAPER_TABLE_1, "N_over_p", S, ours_n_over_p, {1.31, 1.27, 1.22, 1.06}, {0}, D(0.01)},
    {PAPER_TABLE_1, "Z2", S, ours_z2, {1.49, 1.50, 1.49, 1.51}, {0}, D(0.01)},
    {PAPER_TABLE_1, "Z3", S, ours_z3, {2.81, 2.83, 2.77, 2.90}, {0}, D(0.01)},
    {PAPER_TABLE_1, "F2", S, ours_f2, {0.527, 0.524, 0.523, 0.524}, {0}, D(0.001)},
    {PAPER_TABLE_1, "F2S", S, ours_f2s, {0.557, 0.560, 0.558, 0.578}, {0}, D(0.001)},
    {PAPER_TABLE_2, "s1_over_s2", S, ours_s1_over_s2, {0.79, 0.79, 0.78, 0.71}, {0.06, 0.06, 0.06, 0.04}, D(0.01)},
    {PAPER_TABLE_2, "C11", M, ours_c11, {9.9e-4, 2.3e-3, 5.4e-3, 1.35e-2}, {0.9e-4, 0.2e-3, 0.5e-3, 0.09e-2}, {0.1e-4, 0.1e-3, 0.1e-3, 0.01e-2}},
    {PAPER_TABLE_2, "C12", M, ours_c12, {8.1e-4, 1.7e-3, 3.5e-3, 6.8e-3}, {0.4e-4, 0.08e-3, 0.2e-3, 0.4e-3}, {0.1e-4, 0.1e-3, 0.1e-3, 0.1e-3}},
    {PAPER_TABLE_2, "C22", M, ours_c22, {13.9e-4, 3.2e-3, 7.4e-3, 1.88e-2}, {0.8e-4, 0.2e-3, 0.3e-3, 0.08e-2}, {0.1e-4, 0.1e-3, 0.1e-3, 0.01e-2}},
    {PAPER_TABLE_2, "C33", M, ours_c33, {1.2e-4, 0.35e-3, 1.1e-3, 4.0e-3}, {0.4e-4, 0.07e-3, 0.2e-3, 0.5e-3}, {0.1e-4, 0.01e-3, 0.1e-3, 0.1e-3}},
    {PAPER_TABLE_4, "C22(1)/C22", P, ours_sine1_22, {0.85, 0.88, 0.91, 0.93}, {0.05, 0.04, 0.05, 0.04}, D(0.01)},
    {PAPER_TABLE_4, "C22(2)/C22", P, ours_sine2_22, {0.74, 0.80, 0.86, 0.88}, {0.09, 0.06, 0.06, 0.04}, D(0.01)},
    {PAPER_TABLE_4, "C33(1)/C33", P, ours_sine1_33, {0.81, 0.90, 0.85, 0.85}, {0.14, 0.20, 0.10, 0.10}, D(0.01)},
    {PAPER_TABLE_4, "C33(2)/C33", P, ours_sine2_33, {1.01, 0.96, 0.89, 0.90}, {0.24, 0.16, 0.11, 0.07}, D(0.01)},
    {PAPER_TABLE_5, "C22(1)/C22", P, ours_lines1_22, {1.01, 1.01, 1.01, 1.00}, {0.02, 0.01, 0.02, 0.01}, D(0.01)},
    {PAPER_TABLE_5, "C22(3)/C22", P, ours_lines3_22, {1.09, 1.07, 1.06, 1.03}, {0.03, 0.07, 0.03, 0.02}, D(0.01)},
    {PAPER_TABLE_5, "C33(1)/C33", P, ours_lines1_33, {1.26, 1.28, 1.15, 1.08}, {0.16, 0.20, 0.11, 0.05}, D(0.01)},
    {PAPER_TABLE_5, "C33(3)/C33", P, ours_lines3_33, {2.49, 2.05, 1.65, 1.37}, {0.69, 0.45, 0.30, 0.14}, D(0.01)},
};
/* clang-format on */
const int sp_paper_quantity_count = (int)(sizeof sp_paper_quantities / sizeof *sp_paper_quantities);
