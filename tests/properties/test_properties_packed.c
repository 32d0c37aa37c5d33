/* Packings made from random scenes: rest, balance, moduli against strain really applied, and small sound against the
 * nonlinear motion. */
#include "properties/claims.h"

#include <sonopack/elastic.h>
#include <sonopack/modes.h>
#include <sonopack/packing.h>
#include <sonopack/signal.h>

#ifndef SCENES
#define SCENES 8
#define FIRST  "5" /* scene 4 takes longer than these together: it is for the long test */
#else
#define FIRST "1"
#endif

static sp_pack_spec spec_draw(sp_random *draw) {
    static const double frictions[] = {0, 0.05, 0.3, 0.5, 1, 1e6}, ratios[] = {0, 0.2, 0.5},
                        pressures[] = {1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2}, widest[] = {1, 1.05, 1.2, 1.5};
    sp_pack_spec s = sp_pack_spec_default();
    s.dim = whole(draw, 2, 3);
    s.cell = (sp_cell)whole(draw, 0, 2);
    s.grains = s.dim == 2 ? whole(draw, 14, 40) : whole(draw, 40, 70);
    s.width = s.cell == SP_CELL_PISTON ? between(draw, 6.1, 7) : s.width;
    s.depth = s.dim == 3 && s.cell == SP_CELL_PISTON ? s.width : 0;
    s.pressure = one_of(draw, 6, pressures);
    s.friction = one_of(draw, 6, frictions);
    s.poisson = one_of(draw, 3, ratios);
    s.protocol = (sp_protocol)whole(draw, 0, 3);
    s.diameter_max = one_of(draw, 4, widest);
    if (s.dim == 3)
        s.diameter_max = fmin(s.diameter_max, 1.2);
    s.diameter_min = 2 - s.diameter_max;
    if (s.cell != SP_CELL_PISTON) /* four of the largest diameters along an edge */
        s.grains = (int32_t)((s.dim == 2 ? 1.2 : 1.3) * pow(4.1 * s.diameter_max, s.dim));
    s.sizes = chance(draw, 0.3) ? SP_SIZES_BIDISPERSE : SP_SIZES_UNIFORM;
    if (s.cell == SP_CELL_PISTON && chance(draw, 0.3))
        s.gravity = 0.3 * s.pressure;
    if (s.dim == 2 && s.friction > 0 && chance(draw, 0.3))
        s.tangential = SP_TANGENTIAL_HISTORY;
    s.seed = 1 + sp_random_below(draw, 1000000);
    return s;
}

/* The largest mass of a sphere in units of that of diameter 1, over which accelerations become forces. */
static void check_rest(claims *c, const sp_pack_spec *s, const sp_packing *p) {
    const double most = s->diameter_max, mass = 0.5236 * most * most * most;
    sp_audit a;
    sp_error why = {0};
    claims_true(c, "a packing", sp_packing_check(p, &why) == SP_OK);
    assert_ok(sp_packing_audit(p, 0, &a, &err));
    const double rest = fmin(1e-10, 1e-6 * p->pressure);
    claims_check(c, "residual below the tolerance", p->residual, rest);
    claims_check(c, "forces balance", a.force_residual * p->pressure, 1.05 * rest * mass);
    claims_check(c, "torques balance", a.torque_residual * p->pressure, 1.05 * rest * 0.4 * mass * 1.05);
    claims_check(c, "Coulomb's limit", a.coulomb_excess, 1e-12);
    claims_check(c, "Hertz's law", a.law_residual, 1e-12);
    claims_true(c, "no contact is missing", a.missing == 0);
}

/* Springs against the strain of the packing itself: what differs is of the order of the strain over that of the
 * contacts, where none slides, opens or closes. */
static void check_strain(claims *c, const sp_packing *p, const sp_network *net) {
    sp_finite_strain_options o = sp_finite_strain_options_default();
    sp_finite_strain f;
    sp_moduli m;
    sp_error why = {0};
    double overlap = INFINITY;
    for (int32_t k = 0; k < p->n_contacts; k++)
        overlap = fmin(overlap, p->contacts[k].overlap);
    o.strain = 1e-4 * overlap;
    if (!claims_served(c, "moduli", sp_moduli_make(net, NAN, &m, &why), &why) ||
        !claims_served(c, "finite strain", sp_moduli_finite_strain(p, net, NAN, &o, &f, &why), &why))
        return;
    if (f.sliding || f.lost || f.made)
        return;
    const double all[][3] = {{m.c11, f.moduli.c11, m.error11}, {m.c22, f.moduli.c22, m.error22},
                             {m.c33, f.moduli.c33, m.error33}, {m.c12, f.moduli.c12, m.error12},
                             {m.c55, f.moduli.c55, m.error55}, {m.c66, f.moduli.c66, m.error66}};
    for (int k = 0; k < 6; k++)
        if (!isnan(all[k][0]) && !isnan(all[k][1]))
            claims_check(c, "moduli at finite strain", fabs(all[k][0] - all[k][1]),
                         all[k][2] + 1e-3 * fmax(fmax(fabs(m.c11), fabs(m.c22)), fabs(m.c33)));
}

/* The nonlinear motion of a small amplitude is the linear one: the difference falls as the amplitude. */
static void check_small(claims *c, const sp_packing *p, const sp_network *net) {
    sp_signal_options o = sp_signal_options_default();
    FREED(sp_signal) linear = sp_signal_none(), real = sp_signal_none();
    sp_error why = {0};
    double peak = 0, off = 0;
    o.until = 30 / net->omega_bound;
    o.points = 16;
    o.amplitude = 1e-6;
    if (p->cell == SP_CELL_PERIODIC || !claims_served(c, "linear", sp_signal_make(net, &o, &linear, &why), &why))
        return;
    o.method = SP_SIGNAL_DYNAMICS;
    o.tolerance = 1e-3;
    if (claims_served(c, "nonlinear", sp_signal_compute(p, net, &o, &real, &why), &why)) {
        for (int q = 0; q < o.points; q++) {
            peak = fmax(peak, fabs(linear.f[q]));
            off = fmax(off, fabs(linear.f[q] - real.f[q]));
        }
        claims_check(c, "small amplitude is linear", off, 2 * real.error + linear.error + 100 * o.amplitude * peak);
    }
}

/* Contacts that are within 1% of Coulomb's limit slide at any amplitude. */
static bool sticks(const sp_packing *p) {
    bool all = true;
    for (int32_t k = 0; k < p->n_contacts && p->friction > 0; k++) {
        const sp_contact *t = &p->contacts[k];
        all = all && sqrt(t->ft[0] * t->ft[0] + t->ft[1] * t->ft[1] + t->ft[2] * t->ft[2]) < 0.99 * p->friction * t->fn;
    }
    return all;
}

static void run(claims *c, sp_random *draw) {
    const sp_pack_spec s = spec_draw(draw);
    FREED(sp_packing) p = sp_packing_none();
    sp_error why = {0};
    char words[200];
    snprintf(words, sizeof words, "%dD, cell %d, %d grains, p %g, friction %g, protocol %d, d %g, gravity %g, seed %d",
             s.dim, (int)s.cell, s.grains, s.pressure, s.friction, (int)s.protocol, s.diameter_max, s.gravity,
             (int)s.seed);
    c->words = words;
    const sp_status status = sp_packing_make(&s, NULL, NULL, &p, &why);
    if (status == SP_EINVAL || status == SP_EFAILED) { /* a gas too dense; no rest: said, not hidden */
        claims_find(c, "a packing")->refused++;
        print_message("no packing: %s: %s\n", words, why.text);
        return;
    }
    claims_true(c, "made", status == SP_OK);
    check_rest(c, &s, &p);
    sp_network_options o = sp_network_options_default();
    FREED(sp_network) net = sp_network_none();
    o.prestress = true;
    o.threshold = 0;
    if (claims_served(c, "network", sp_network_make(&p, &o, &net, &why), &why)) {
        if (sticks(&p)) {
            check_strain(c, &p, &net);
            check_small(c, &p, &net);
        }
    }
}

TEST(test_packed) {
    claims c = {0};
    setenv("SONOPACK_PROPERTIES_SEED", FIRST, 0);
    claims_scenes(&c, SCENES, run);
    claims_close(&c);
}

/* A smooth sphere that rests on three others by its weight: no rattler. */
TEST(test_known) {
    static const uint64_t known[] = {41};
    claims c = {0};
    claims_known(&c, 1, known, run);
    claims_close(&c);
}

RUN_TESTS(NULL, NULL)
