/* Makes Fig. 12: fronts of chains and of the triangular lattice, with the Airy front. */
#include "base/base.h"
#include "paper/paper.h"

#include <math.h>
#include <sonopack/chain.h>
#include <sonopack/signal.h>
#include <stdio.h>
#include <string.h>

enum { CHAINS = 3, POINTS = 401, LATTICE_POINTS = 61, ROWS = 20, CURVES = CHAINS + 3 };
static const int64_t balls[CHAINS] = {ROWS, 200, 2000};
static const double scaled_low = -2.5, scaled_high = 5; /* range of (t - N)/N^(1/3) */

/* A scaled front in the units of the chain: x = (t - N)/N^(1/3), y = F N^(2/3). */
typedef struct scaled {
    int64_t n;
    double x[POINTS], y[POINTS];
} scaled;

static sp_status chain_front(int64_t n, bool airy, scaled *out, sp_error *err) {
    double t[POINTS];
    const double length = (double)n, third = cbrt(length);
    out->n = POINTS;
    for (int k = 0; k < POINTS; k++) {
        out->x[k] = scaled_low + (scaled_high - scaled_low) * k / (POINTS - 1);
        t[k] = length + out->x[k] * third;
    }
    sp_status status = airy ? sp_chain_airy(n, SP_CHAIN_VELOCITY, POINTS, t, out->y, err)
                            : sp_chain_signal(n, SP_CHAIN_VELOCITY, POINTS, t, out->y, err);
    for (int k = 0; k < POINTS; k++)
        out->y[k] *= third * third;
    return status;
}

/* Maps the lattice to a chain. A row of M grains is a ball; the two contacts of each grain with the next row are its
 * spring. */
typedef struct lattice {
    scaled front;
    double mass, spring, wall; /* per grain */
    double row;                /* grains per row */
} lattice;

static void measure(const sp_network *net, lattice *out) {
    double springs = 0;
    *out = (lattice){.mass = net->mass[0]};
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        if (s->j == SP_TOP) {
            out->wall = s->kn;
            out->row++;
        } else if (s->j >= 0 && fabs(s->n[1]) > 0.5) {
            out->spring += 2 * s->kn * s->n[1] * s->n[1];
            springs++;
        }
    }
    out->spring /= springs;
}

static sp_status lattice_front(const sp_sample *sample, const sp_packing *packing, const sp_network *net, void *user,
                               sp_error *err) {
    (void)packing;
    lattice *l = user;
    if (sample->friction > 0)
        return SP_OK;
    measure(net, l);
    const double unit = sqrt(l->mass / l->spring), third = cbrt((double)ROWS);
    sp_signal_options options = sp_signal_options_default();
    options.method = SP_SIGNAL_CHEBYSHEV;
    options.until = (ROWS + scaled_high * third) * unit;
    options.points = LATTICE_POINTS + 20;
    sp_signal signal = sp_signal_none();
    sp_status status = sp_signal_make(net, &options, &signal, err);
    for (int32_t k = 0; status == SP_OK && k < signal.n; k++) {
        const double x = (signal.t[k] / unit - ROWS) / third;
        if (x < scaled_low)
            continue;
        /* the first row starts with k_wall/m, the first ball of the chain with velocity 1 */
        l->front.x[l->front.n] = x;
        l->front.y[l->front.n++] = signal.f[k] / l->row * l->mass / (l->wall * l->spring * unit) * third * third;
    }
    sp_signal_free(&signal);
    return status;
}

/* Front of the chain with the number of rows and the wall stiffness of the lattice. */
static sp_status mapped_chain(const lattice *l, int64_t n, const double *x, double *y, sp_error *err) {
    const sp_chain chain = {.grains = ROWS, .source = SP_CHAIN_VELOCITY, .wall = l->wall / l->spring};
    const double third = cbrt((double)ROWS);
    double t[POINTS];
    for (int64_t k = 0; k < n; k++)
        t[k] = ROWS + x[k] * third;
    sp_status status = sp_chain_walls_signal(&chain, n, t, y, err);
    for (int64_t k = 0; k < n; k++)
        y[k] *= third * third;
    return status;
}

static sp_status say_lattice(paper *p, int item, const lattice *l, sp_error *err) {
    double y[POINTS], apart = 0, largest = 0;
    sp_status status = mapped_chain(l, l->front.n, l->front.x, y, err);
    for (int64_t k = 0; status == SP_OK && k < l->front.n; k++) {
        apart = fmax(apart, fabs(y[k] - l->front.y[k]));
        largest = fmax(largest, fabs(y[k]));
    }
    if (status == SP_OK)
        sp_paper_say(
            p, item,
            "The lattice of %d rows, its first row as fast as the chain's first ball, has the signal of a chain of %d "
            "balls with such walls, to %.1g of the largest value shown: its front is lower and earlier than that of "
            "a chain whose springs are all equal.",
            ROWS, ROWS, apart / largest);
    return status;
}

static sp_status draw(paper *p, int item, const lattice *l, sp_error *err) {
    static const sp_dash dashes[CHAINS] = {SP_DASH_DOTTED, SP_DASH_DASH_DOT, SP_DASH_DASHED};
    scaled *front = sp_alloc(CHAINS + 2, sizeof *front);
    if (!front)
        return sp_fail_memory(err, (CHAINS + 2) * sizeof *front);
    sp_curve curve[CURVES];
    char label[CHAINS][32];
    sp_status status = chain_front(1000000000, true, &front[CHAINS], err);
    curve[0] =
        (sp_curve){.label = "Airy, Eq. (16)", .n = POINTS, .x = front[CHAINS].x, .y = front[CHAINS].y, .width = 1.8};
    for (int k = 0; k < CHAINS && status == SP_OK; k++) {
        status = chain_front(balls[k], false, &front[k], err);
        snprintf(label[k], sizeof label[k], "chain, |N| = %lld", (long long)balls[k]);
        curve[1 + k] = (sp_curve){
            .label = label[k], .n = POINTS, .x = front[k].x, .y = front[k].y, .ink = 1 + k, .dash = dashes[k]};
    }
    curve[CURVES - 1] = (sp_curve){.label = "lattice, 20 rows",
                                   .n = l->front.n,
                                   .x = l->front.x,
                                   .y = l->front.y,
                                   .ink = 1,
                                   .dash = SP_DASH_NONE,
                                   .mark = SP_MARK_CIRCLE,
                                   .open = true};
    scaled *mapped = &front[CHAINS + 1];
    *mapped = front[CHAINS];
    if (status == SP_OK)
        status = mapped_chain(l, POINTS, mapped->x, mapped->y, err);
    curve[CURVES - 2] = (sp_curve){.n = POINTS, .x = mapped->x, .y = mapped->y, .ink = 1, .width = 0.7};
    const sp_panel panel = {.x = {"(|ct|/|ℓ| − |N|) / |N|^{1/3}", false, scaled_low, scaled_high},
                            .y = {"|F| |N|^{2/3} / |Kℓ|", false, NAN, NAN},
                            .curves = CURVES,
                            .curve = curve,
                            .zero_line = true};
    const sp_sheet sheet = {.title = "Airy front", .rows = 1, .columns = 1, .panel = &panel};
    if (status == SP_OK)
        status =
            sp_paper_draw(p, item, "fig12", &sheet,
                          "Force of the last ball on its wall after a velocity of the first (A), against the time "
                          "after N l/c: chains of N balls, their limit, a triangular lattice of 20 rows (circles), "
                          "and a chain with walls as stiff as the lattice's (thin line).",
                          err);
    sp_free(front);
    return status;
}

sp_status sp_paper_make_fig12(paper *p, int item, sp_error *err) {
    lattice l = {0};
    sp_status status = sp_paper_walk(p, PAPER_LATTICE_LONG, 5e-7, 24 * ROWS, 0, lattice_front, &l, err);
    const double theory[2] = {pow(3, 5.0 / 6) / 4, 0.005}, ours[2] = {l.wall / l.spring, 0};
    if (status == SP_OK)
        status = sp_paper_add_stated(p, item, 5e-7, PAPER_SCATTER_STATED, theory, ours, err,
                                     "K_wall / K_bulk of the lattice");
    if (status == SP_OK && fabs(l.spring / l.wall - theory[0]) < theory[1])
        sp_paper_say(
            p, item,
            "The walls' springs are %.3f times as stiff as those between rows, which is Hertz's law for rigid walls; "
            "the number in the paper is the inverse, %.3f.",
            l.wall / l.spring, l.spring / l.wall);
    const double limit = sp_chain_limit_of(SP_CHAIN_VELOCITY).height;
    for (int k = 0; k < CHAINS && status == SP_OK; k++) {
        sp_front front;
        status = sp_chain_front(balls[k], SP_CHAIN_VELOCITY, &front, err);
        if (status == SP_OK)
            sp_paper_say(p, item,
                         "Chain of %lld balls: the first peak's height times N^(2/3) is %.2f%% below its limit.",
                         (long long)balls[k], 100 * (1 - front.amplitude * pow((double)balls[k], 2.0 / 3) / limit));
    }
    if (status == SP_OK)
        status = say_lattice(p, item, &l, err);
    return status == SP_OK && p->opt->folder ? draw(p, item, &l, err) : status;
}
