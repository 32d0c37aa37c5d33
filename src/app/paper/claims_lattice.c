/* Checks claims on triangular lattices of equal balls (Fig. 8) and of slightly unequal ones. */
#include "paper/claims.h"
#include "paper/lattice.h"

#include <math.h>
#include <stdio.h>

/* ---- equal balls ------------------------------------------------------------------------------------------------ */

sp_status sp_paper_claim_lattices(paper *p, sp_error *err) {
    const double pressure = 5e-7;
    double off[2], far[2];
    for (int friction = 0; friction < 2; friction++) {
        const double theory = sp_paper_lattice_speed(pressure, friction ? 1 : 0);
        double between;
        sp_paper_lattice_long(p, friction, &between);
        off[friction] = sp_paper_lattice_small(p, friction, pressure) / theory;
        far[friction] = between / theory;
    }
    paper_claim claim = {.where = "Fig. 8",
                         .relation = PAPER_EQUAL,
                         .limit = 1,
                         .within = 0.03,
                         .p = pressure,
                         .note = "lattices of L = 24 without friction agree excellently with Eq. (18), to 3% is meant "
                                 "here; by the definition of c_tof, t10 at L = 8 and 24"};
    sp_status status = sp_paper_add_claim(p, &claim, off[0], 0, err, "lattice, L = 24, c over Eq. (18)");
    claim.relation = PAPER_BELOW;
    claim.note = "the frictional lattice of L = 24 lies below Eq. (19), the top side of the band, for its finite size; "
                 "the same definition";
    if (status == SP_OK)
        status = sp_paper_add_claim(p, &claim, off[1], 0, err, "frictional lattice, L = 24, c over Eq. (19)");
    claim.note = "the frictional lattice has significant finite size scaling and approaches Eq. (19): what is left of "
                 "the difference at L = 160, by t10 at L = 80 and 160";
    if (status == SP_OK)
        status = sp_paper_add_claim(p, &claim, fabs(far[1] - 1) / fabs(off[1] - 1), 0, err,
                                    "frictional: |c - (19)|, L = 160 over 24");
    claim.relation = PAPER_ABOVE;
    claim.note =
        "the frictional lattice shows appreciable finite size corrections, unlike that without friction: their "
        "differences from (19) and (18) at L = 24";
    if (status == SP_OK)
        status = sp_paper_add_claim(p, &claim, fabs(off[1] - 1) / fabs(off[0] - 1), 0, err,
                                    "|c - (19)| over |c - (18)|, L = 24");
    return status;
}

/* ---- unequal balls ---------------------------------------------------------------------------------------------- */

/* Mean and error of a quantity over samples of a set. */
static paper_sum mean_over(const paper_set *set, bool friction, double pressure, int32_t grains, unsigned part,
                           double (*of)(const sp_sample *s)) {
    paper_sum s = {0};
    for (int64_t k = 0; k < set->n; k++) {
        const sp_sample *one = &set->sample[k];
        if ((one->friction > 0) == friction && fabs(one->pressure - pressure) < 1e-9 * pressure &&
            one->grains == grains && one->have & part)
            sp_paper_sum_add(&s, of(one));
    }
    return s;
}

static double t10(const sp_sample *s) { return s->front.t10; }
static double height(const sp_sample *s) { return s->height; }
static double zs(const sp_sample *s) { return s->statics.zs; }

enum { LOW = 216, HIGH = 672 }; /* numbers of grains */

static double uneven_speed(const paper_set *set, bool friction, double pressure, double *error) {
    const paper_sum h1 = mean_over(set, friction, pressure, LOW, SP_WANT_CTOF, height),
                    h2 = mean_over(set, friction, pressure, HIGH, SP_WANT_CTOF, height),
                    t1 = mean_over(set, friction, pressure, LOW, SP_WANT_CTOF, t10),
                    t2 = mean_over(set, friction, pressure, HIGH, SP_WANT_CTOF, t10);
    const double time = sp_paper_sum_mean(&t2) - sp_paper_sum_mean(&t1),
                 speed = (sp_paper_sum_mean(&h2) - sp_paper_sum_mean(&h1)) / time;
    *error = speed * hypot(sp_paper_sum_err(&t1), sp_paper_sum_err(&t2)) / time;
    return speed;
}

/* At P* >= 1, speed and contacts are those of the perfect lattice. Below that, disorder has an effect. */
static sp_status claim_uneven(paper *p, bool friction, double pressure, double reduced, sp_error *err) {
    const paper_set *set = &p->set[PAPER_UNEVEN];
    const char *kind = friction ? "friction" : "smooth";
    const double perfect = sp_paper_lattice_small(p, friction, pressure);
    double error;
    const double speed = uneven_speed(set, friction, pressure, &error);
    paper_claim claim = {.where = "Sec. VI",
                         .relation = PAPER_BELOW,
                         .limit = 0.98,
                         .p = pressure,
                         .samples = mean_over(set, friction, pressure, HIGH, SP_WANT_CTOF, t10).n,
                         .note = "recruitment of contacts stiffens a lattice of unequal balls: below P* = 1 it is "
                                 "slower than the perfect one, by 2% is meant here"};
    if (reduced >= 1) {
        claim.where = "Sec. IV D";
        claim.relation = PAPER_EQUAL;
        claim.limit = 1;
        claim.within = 0.02;
        claim.note = "effects of polydispersity disappear as P* grows beyond 1: c_tof over that of the lattice of "
                     "equal balls, both from L = 8 and 24; to 2% is meant here";
    }
    sp_status status = sp_paper_add_claim(p, &claim, speed / perfect, error / perfect, err,
                                          "P* = %g, %s: c over the lattice's", reduced, kind);
    if (status != SP_OK || reduced < 1)
        return status;
    const paper_sum z = mean_over(set, friction, pressure, HIGH, SP_WANT_STATICS, zs);
    claim.where = "Sec. VI";
    claim.limit = 6;
    claim.within = 0.1;
    claim.note = "the coordination number only recovers the perfect lattice's at P* >= 1: to 0.1 is meant here";
    return sp_paper_add_claim(p, &claim, sp_paper_sum_mean(&z), sp_paper_sum_err(&z), err, "P* = %g, %s: contacts z*",
                              reduced, kind);
}

/* z* at the two lowest pressures, and its limit at p = 0 from z0 + a sqrt(p). */
static sp_status claim_four(paper *p, sp_error *err) {
    const paper_set *set = &p->set[PAPER_UNEVEN_LOW];
    const double lower = 1e-7, upper = 1e-6, root = sqrt(upper / lower);
    sp_status status = SP_OK;
    for (int friction = 0; friction < 2 && status == SP_OK; friction++) {
        const char *kind = friction ? "friction" : "smooth";
        const paper_sum a = mean_over(set, friction, lower, HIGH, SP_WANT_STATICS, zs),
                        b = mean_over(set, friction, upper, HIGH, SP_WANT_STATICS, zs);
        const double low = sp_paper_sum_mean(&a), high = sp_paper_sum_mean(&b), limit = low - (high - low) / (root - 1),
                     error = hypot(sp_paper_sum_err(&a) * root, sp_paper_sum_err(&b)) / (root - 1);
        const paper_claim claim = {.where = "Sec. IV D",
                                   .relation = PAPER_BELOW,
                                   .limit = 4,
                                   .p = NAN,
                                   .samples = a.n,
                                   .note =
                                       "in the limit of low pressure the coordination number of a slightly "
                                       "polydisperse lattice should not exceed 4: to p = 0 as sqrt(p) from 1e-6 and "
                                       "1e-7, alpha = 0.01"};
        status = sp_paper_add_claim(p, &claim, limit, error, err, "%s: z* of an uneven lattice at p = 0", kind);
        sp_paper_say(
            p, PAPER_CLAIMS, "Lattice of balls 1 +- 0.005, %s: z* = %.3f +- %.3f at p = 1e-7, %.3f +- %.3f at 1e-6.",
            friction ? "with friction" : "without friction", low, sp_paper_sum_err(&a), high, sp_paper_sum_err(&b));
    }
    return status;
}

sp_status sp_paper_claim_unequal(paper *p, sp_error *err) {
    /* pressures of PAPER_UNEVEN, and P* = 3 p/alpha^(3/2) */
    static const double pressure[][2] = {{1e-6, 0.1}, {1e-5, 1}, {1e-4, 10}};
    sp_status status = SP_OK;
    for (int k = 0; k < 3; k++)
        for (int friction = 0; friction < 2 && status == SP_OK; friction++)
            status = claim_uneven(p, friction, pressure[k][0], pressure[k][1], err);
    return status == SP_OK ? claim_four(p, err) : status;
}
