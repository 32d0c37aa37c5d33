/* Makes Figs. 1 and 2: forces, stiffnesses and directions of contacts. */
#include "base/base.h"
#include "paper/paper.h"

#include <math.h>
#include <sonopack/counts.h>
#include <sonopack/figure/plot.h>
#include <stdio.h>

static const double threshold = 1e-4; /* least force of a contact that carries load [p d^2] */

/* ---- Fig. 1 ----------------------------------------------------------------------------------------------------- */

typedef struct networks {
    paper *p;
    int item;
    bool drawn;
    sp_contact_counts counts;
} networks;

/* Saves the contacts of Figs. 1(a) and (b) as a table. */
static sp_status save_links(paper *p, const char *name, const sp_packing *packing, const sp_network *net,
                            sp_error *err) {
    static const char *const column[] = {"i", "j", "x_i", "y_i", "x_contact", "y_contact", "Fn", "kn"};
    sp_table t = sp_table_none();
    sp_status status = sp_table_add_comment(&t, err,
                                            "contacts that carry: grains from 0, -1 and -2 the bottom and the "
                                            "top wall; normal force and stiffness");
    for (int k = 0; k < 8 && status == SP_OK; k++)
        status = sp_table_add_column(&t, column[k], "", SP_COLUMN_NUMBER, err);
    for (int32_t k = 0; k < net->n_springs && status == SP_OK; k++) {
        const sp_spring *s = &net->springs[k];
        const sp_contact *c = &packing->contacts[s->contact];
        const double *x = packing->x + 3 * (size_t)c->i, r = packing->r[c->i];
        const double row[8] = {c->i, c->j, x[0], x[1], x[0] + r * c->n[0], x[1] + r * c->n[1], c->fn, s->kn};
        status = sp_table_add_numbers(&t, row, err);
    }
    if (status == SP_OK)
        status = sp_paper_save_table(p, name, &t, err);
    sp_table_free(&t);
    return status;
}

static sp_status draw_networks(networks *all, const sp_packing *packing, const sp_network *net, sp_error *err) {
    static const struct {
        const char *name, *caption;
        sp_plot_links links;
    } part[2] = {
        {"fig1a", "(a) Normal forces in one packing of 600 grains at p = 1e-4, as widths of lines.", SP_PLOT_FORCES},
        {"fig1b", "(b) Normal stiffnesses of the same contacts.", SP_PLOT_STIFFNESS}};
    paper *p = all->p;
    sp_status status = SP_OK;
    for (int k = 0; k < 2 && status == SP_OK; k++) {
        char path[SP_PATH_MAX];
        sp_paper_path(p, part[k].name, p->opt->figures, path);
        status = sp_plot_network(packing, part[k].links, threshold, path, err);
        if (status == SP_OK)
            sp_paper_add_figure(p, all->item, part[k].name, part[k].caption);
    }
    return status == SP_OK ? save_links(p, "fig1ab", packing, net, err) : status;
}

static sp_status add_network(const sp_sample *s, const sp_packing *packing, const sp_network *net, void *user,
                             sp_error *err) {
    (void)s;
    networks *all = user;
    sp_status status = SP_OK;
    if (!all->drawn)
        status = draw_networks(all, packing, net, err);
    all->drawn = true;
    return status == SP_OK ? sp_contact_counts_add(&all->counts, packing, threshold, 0, err) : status;
}

/* Standard deviation relative to the mean, from a histogram of values relative to their mean. */
static double spread(const sp_table *t, int column) {
    double sum = 0, bins = 0;
    for (int64_t k = 0; k < t->rows; k++) {
        const double x = sp_table_number(t, k, 0) - 1, density = sp_table_number(t, k, column);
        sum += density * x * x;
        bins += density;
    }
    return sqrt(sum / bins);
}

static sp_status draw_histogram(const networks *all, sp_table *t, sp_error *err) {
    paper *p = all->p;
    char path[SP_PATH_MAX];
    sp_paper_path(p, "fig1c", p->opt->figures, path);
    sp_status status = sp_plot_contact_values(t, path, err);
    if (status == SP_OK)
        status = sp_paper_save_table(p, "fig1c", t, err);
    if (status == SP_OK)
        sp_paper_add_figure(
            p, all->item, "fig1c",
            "(c) Histograms of the normal forces and stiffnesses of all contacts that carry, over their means; "
            "equal areas.");
    return status;
}

sp_status sp_paper_make_fig1(paper *p, int item, sp_error *err) {
    networks all = {.p = p, .item = item, .counts = sp_contact_counts_none()};
    sp_table t = sp_table_none();
    sp_status status = sp_paper_walk(p, PAPER_SQUARE, 1e-4, 0, 0, add_network, &all, err);
    if (status == SP_OK)
        status = sp_contact_values_table(&all.counts, &t, err);
    if (status == SP_OK)
        status = draw_histogram(&all, &t, err);
    if (status == SP_OK)
        sp_paper_say(
            p, item,
            "Over %.0f contacts of %lld packings the forces scatter by %.0f%% of their mean and the stiffnesses by "
            "%.0f%%: k_n goes as F_n^(1/3).",
            all.counts.contacts, (long long)all.counts.packings, 100 * spread(&t, 1), 100 * spread(&t, 3));
    sp_table_free(&t);
    return status;
}

/* ---- Fig. 2 ----------------------------------------------------------------------------------------------------- */

static sp_status add_directions(const sp_sample *s, const sp_packing *packing, const sp_network *net, void *user,
                                sp_error *err) {
    (void)s;
    (void)net;
    return sp_contact_counts_add(user, packing, threshold, 3, err);
}

/* Mean of cos 2(angle - 90 degrees): 0 if isotropic, positive if contacts are mostly vertical. */
static double upright(const sp_table *t, int column) {
    double sum = 0, weight = 0;
    for (int64_t k = 0; k < t->rows; k++) {
        const double density = sp_table_number(t, k, column),
                     angle = sp_table_number(t, k, 0) / 180 * 3.14159265358979323846;
        sum -= density * cos(2 * angle);
        weight += density;
    }
    return sum / weight;
}

sp_status sp_paper_make_fig2(paper *p, int item, sp_error *err) {
    sp_contact_counts counts = sp_contact_counts_none();
    sp_table t = sp_table_none();
    sp_status status = sp_paper_walk(p, PAPER_SQUARE, 1e-4, 0, 0, add_directions, &counts, err);
    if (status == SP_OK)
        status = sp_contact_angles_table(&counts, &t, err);
    char path[SP_PATH_MAX];
    sp_paper_path(p, "fig2", p->opt->figures, path);
    if (status == SP_OK)
        status = sp_plot_angles(&t, path, err);
    if (status == SP_OK) {
        sp_paper_add_figure(
            p, item, "fig2",
            "Directions of contacts that carry, at least three diameters from both walls: all, those with "
            "forces above the mean (strong), and the others (weak).");
        sp_paper_say(
            p, item,
            "%.0f contacts of %lld packings. The mean of 2 n_y^2 - 1, 0 without anisotropy, is %+.3f for all, %+.3f "
            "for strong and %+.3f for weak contacts.",
            counts.contacts, (long long)counts.packings, upright(&t, 1), upright(&t, 3), upright(&t, 5));
        status = sp_paper_save_table(p, "fig2", &t, err);
    }
    sp_table_free(&t);
    return status;
}
