/* Checks claims on soft modes and on damping. */
#include "paper/claims.h"
#include "paper/signals.h"

#include <math.h>
#include <sonopack/modes.h>

enum { PACKINGS = 10 }; /* the first packings of each ensemble */

/* ---- modes of low frequency ------------------------------------------------------------------------------------- */

static const double soft = 0.1; /* low modes have frequencies below this; the highest are near 2 at p = 1e-4 */

typedef struct soft_modes {
    paper *p;
    paper_sum number;
} soft_modes;

static sp_status count_soft(const sp_sample *sample, const sp_packing *packing, const sp_network *net, void *user,
                            sp_error *err) {
    (void)sample, (void)packing;
    soft_modes *s = user;
    sp_modes m = sp_modes_none();
    sp_modes_options options = sp_modes_options_default();
    options.vectors = false;
    sp_status status = sp_modes_dense(net, &options, &m, err);
    if (status == SP_OK) {
        int64_t below = 0;
        for (int64_t k = m.n_zero; k < m.n; k++)
            below += m.omega[k] < soft;
        sp_paper_sum_add(&s->number, (double)below);
        status = sp_paper_tell(s->p, "low modes", 0.9, err);
    }
    sp_modes_free(&m);
    return status;
}

sp_status sp_paper_claim_soft_modes(paper *p, sp_error *err) {
    soft_modes rough = {.p = p}, smooth = {.p = p};
    sp_status status = sp_paper_walk(p, PAPER_SQUARE, 1e-4, 0, PACKINGS, count_soft, &rough, err);
    if (status == SP_OK)
        status = sp_paper_walk(p, PAPER_SMOOTH, 1e-4, 0, PACKINGS, count_soft, &smooth, err);
    if (status != SP_OK)
        return status;
    const double a = sp_paper_sum_mean(&rough.number), b = sp_paper_sum_mean(&smooth.number);
    const paper_claim claim = {.where = "Sec. IV E",
                               .relation = PAPER_ABOVE,
                               .limit = 1,
                               .p = 1e-4,
                               .samples = smooth.number.n,
                               .note = "in the absence of friction the low frequency modes are more abundant: modes of "
                                       "a packing with 0 < omega < 0.1"};
    sp_paper_say(p, PAPER_CLAIMS,
                 "Modes with 0 < omega < %g: %.1f +- %.1f a packing with friction, %.1f +- %.1f without.", soft, a,
                 sp_paper_sum_err(&rough.number), b, sp_paper_sum_err(&smooth.number));
    return sp_paper_add_claim(p, &claim, b / a,
                              b / a * hypot(sp_paper_sum_err(&rough.number) / a, sp_paper_sum_err(&smooth.number) / b),
                              err, "low modes without friction over with");
}

/* ---- damping ---------------------------------------------------------------------------------------------------- */

enum { LEVELS = 3, POINTS = 601 };
static const double zeta[LEVELS] = {0.02, 0.1, 0.5};
static const double until = 300; /* as in Fig. 11 */

/* Ratios to the signal without damping, one value per packing. */
typedef struct damping {
    paper *p;
    paper_sum peak[LEVELS], rest[LEVELS], losses[LEVELS], arrival[LEVELS], t10, t10_damped[LEVELS];
} damping;

static sp_status damped_front(const sp_network *net, double level, sp_front *front, sp_signal *out, sp_error *err) {
    const sp_front_options rule = sp_front_options_default();
    const sp_status status = sp_paper_damped_signal(net, level, until, POINTS, out, err);
    return status == SP_OK ? sp_front_find(out->n, out->t, out->f, &rule, front, err) : status;
}

static sp_status add_damping(const sp_sample *sample, const sp_packing *packing, const sp_network *net, void *user,
                             sp_error *err) {
    (void)sample, (void)packing;
    damping *d = user;
    sp_signal bare = sp_signal_none();
    sp_front first;
    sp_status status = damped_front(net, 0, &first, &bare, err);
    const double rest0 = status == SP_OK ? sp_paper_rms_after(&bare, first.t_zero) : NAN;
    for (int k = 0; k < LEVELS && status == SP_OK; k++) {
        sp_signal s = sp_signal_none();
        sp_front front;
        status = damped_front(net, zeta[k], &front, &s, err);
        if (status == SP_OK) {
            const double peak = front.amplitude / first.amplitude, rest = sp_paper_rms_after(&s, first.t_zero) / rest0;
            sp_paper_sum_add(&d->peak[k], peak);
            sp_paper_sum_add(&d->rest[k], rest);
            sp_paper_sum_add(&d->losses[k], (1 - peak) / (1 - rest));
            sp_paper_sum_add(&d->arrival[k], front.t10 / first.t10);
            sp_paper_sum_add(&d->t10_damped[k], front.t10);
        }
        sp_signal_free(&s);
    }
    if (status == SP_OK) {
        sp_paper_sum_add(&d->t10, first.t10);
        status = sp_paper_tell(d->p, "damping", 0.95, err);
    }
    sp_signal_free(&bare);
    return status;
}

sp_status sp_paper_claim_damping(paper *p, sp_error *err) {
    damping d = {.p = p};
    sp_status status = sp_paper_walk(p, PAPER_SQUARE, 1e-4, 0, PACKINGS, add_damping, &d, err);
    for (int k = 0; k < LEVELS && status == SP_OK; k++) {
        const paper_claim claim = {.where = "Fig. 11",
                                   .relation = PAPER_BELOW,
                                   .limit = 0.5,
                                   .p = 1e-4,
                                   .samples = d.peak[k].n,
                                   .note = "damping affects the coherent part much less than the random part: the loss "
                                           "of the first peak over that of the later root mean square, less than half "
                                           "is meant here"};
        status = sp_paper_add_claim(p, &claim, sp_paper_sum_mean(&d.losses[k]), sp_paper_sum_err(&d.losses[k]), err,
                                    "zeta = %g: loss of the peak over the rest's", zeta[k]);
        sp_paper_say(
            p, PAPER_CLAIMS,
            "zeta = %g: the first peak keeps %.3f +- %.3f of its height, what follows %.3f +- %.3f of its root mean "
            "square; t10 goes from %.1f to %.1f.",
            zeta[k], sp_paper_sum_mean(&d.peak[k]), sp_paper_sum_err(&d.peak[k]), sp_paper_sum_mean(&d.rest[k]),
            sp_paper_sum_err(&d.rest[k]), sp_paper_sum_mean(&d.t10), sp_paper_sum_mean(&d.t10_damped[k]));
    }
    paper_claim claim = {.where = "Sec. IV F",
                         .relation = PAPER_ABOVE,
                         .limit = 0.8,
                         .p = 1e-4,
                         .samples = d.peak[LEVELS - 1].n,
                         .note =
                             "for large damping the coherent part is only slightly altered: height of the first peak "
                             "over that without damping, 0.8 is meant here"};
    if (status == SP_OK)
        status =
            sp_paper_add_claim(p, &claim, sp_paper_sum_mean(&d.peak[LEVELS - 1]), sp_paper_sum_err(&d.peak[LEVELS - 1]),
                               err, "zeta = %g: first peak that is left", zeta[LEVELS - 1]);
    claim.relation = PAPER_EQUAL;
    claim.limit = 1;
    claim.within = 0.1;
    claim.note = "the same: t10 over that without damping, to a tenth is meant here";
    if (status == SP_OK)
        status = sp_paper_add_claim(p, &claim, sp_paper_sum_mean(&d.arrival[LEVELS - 1]),
                                    sp_paper_sum_err(&d.arrival[LEVELS - 1]), err,
                                    "zeta = %g: arrival over that without", zeta[LEVELS - 1]);
    return status;
}
