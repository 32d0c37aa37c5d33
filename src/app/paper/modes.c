/* Makes Figs. 9 and 10: the modes of the packing of Fig. 1. */
#include "base/base.h"
#include "paper/paper.h"

#include <math.h>
#include <sonopack/figure/plot.h>
#include <sonopack/modes.h>
#include <sonopack/spectrum.h>
#include <stdio.h>

enum { PICKED = 6, LOWEST = 25, BODY = 10 }; /* BODY: number of modes compared with those of an elastic body */

/* Picks the modes of Fig. 10: the two lowest above zero, the strongest in the signal in each third of the lower 60% of
 * the spectrum, and the most localised in the highest 10%. */
static bool pick(const sp_modes *m, int64_t out[PICKED]) {
    const int64_t first = m->n_zero, n = m->n - first;
    if (n < 40)
        return false;
    out[0] = first;
    out[1] = first + 1;
    for (int third = 0; third < 3; third++) {
        const int64_t from = first + 2 + third * n / 5, to = first + (third + 1) * n / 5;
        out[2 + third] = from;
        for (int64_t k = from; k < to; k++)
            if (fabs(m->a[k] * m->b[k]) > fabs(m->a[out[2 + third]] * m->b[out[2 + third]]))
                out[2 + third] = k;
    }
    out[5] = m->n - 1;
    for (int64_t k = m->n - n / 10; k < m->n; k++)
        if (m->participation[k] < m->participation[out[5]])
            out[5] = k;
    return true;
}

static sp_status make_modes(const sp_network *net, sp_modes *out, int64_t picked[PICKED], sp_error *err) {
    sp_modes_options options = sp_modes_options_default();
    options.vectors = true;
    sp_status status = sp_modes_dense(net, &options, out, err);
    if (status == SP_OK && !pick(out, picked)) {
        sp_modes_free(out);
        *out = sp_modes_none();
        status = sp_fail(err, SP_EREFUSED, "modes: fewer than 40 above zero");
    }
    return status;
}

/* ---- Fig. 9 ----------------------------------------------------------------------------------------------------- */

typedef struct points {
    double *n, *square, *weight; /* [modes] one allocation */
    double picked_n[PICKED], picked_square[PICKED], picked_weight[PICKED];
    int bodies;
    double body_n[BODY],
        body_square[BODY]; /* modes of the elastic strip, each beside the most similar mode of the packing */
} points;

static sp_status points_make(const sp_modes *m, const int64_t picked[PICKED], points *out, sp_error *err) {
    const size_t n = (size_t)m->n;
    out->n = sp_alloc(3 * n, sizeof *out->n);
    if (!out->n)
        return sp_fail_memory(err, 3 * n * sizeof *out->n);
    out->square = out->n + n;
    out->weight = out->n + 2 * n;
    for (size_t k = 0; k < n; k++) {
        out->n[k] = (double)k;
        out->square[k] = m->omega[k] * m->omega[k];
        out->weight[k] = m->a[k] * m->b[k];
    }
    for (int k = 0; k < PICKED; k++) {
        out->picked_n[k] = (double)picked[k];
        out->picked_square[k] = out->square[picked[k]];
        out->picked_weight[k] = out->weight[picked[k]];
    }
    return SP_OK;
}

/* Adds the modes of an elastic strip with the moduli and density of the packing. Adds nothing if the packing has no
 * bulk moduli. */
static sp_status add_bodies(const paper_work *s, const sp_sample *sample, const sp_network *net, points *out,
                            sp_error *err) {
    sp_continuum c = sp_continuum_none();
    out->bodies = 0;
    if (!(sample->have & SP_WANT_STATICS) || !(sample->statics.phi3s > 0))
        return SP_OK;
    sp_status status = sp_continuum_make(net, sample->statics.phi3s, BODY, SP_SOLVER_AUTO, &c, err);
    for (int k = 0; status == SP_OK && k < c.n && k < BODY; k++) {
        const sp_continuum_row *row = &c.row[k];
        out->body_n[k] = (double)row->n;
        out->body_square[k] = row->omega_continuum * row->omega_continuum;
        out->bodies++;
        if (k < 4)
            sp_paper_say(
                s->p, s->item,
                "Mode %lld, omega = %.4f: most like the %s wave (%d, %d) of an elastic body with the same moduli "
                "between the "
                "same walls, omega = %.4f, squared overlap %.2f.",
                (long long)row->n, row->omega, row->fast ? "fast" : "slow", row->n1, row->n2, row->omega_continuum,
                row->overlap);
    }
    sp_continuum_free(&c);
    return status;
}

static sp_curve circles(int n, const double *x, const double *y) {
    return (sp_curve){.n = n, .x = x, .y = y, .ink = 2, .dash = SP_DASH_NONE, .mark = SP_MARK_CIRCLE, .open = true};
}

static sp_status draw_spectrum(const paper_work *s, const sp_modes *m, const points *q, sp_error *err) {
    const int64_t from = m->n_zero > 2 ? m->n_zero - 2 : 0;
    const sp_curve small[3] = {
        {.n = LOWEST,
         .x = q->n + from,
         .y = q->square + from,
         .dash = SP_DASH_NONE,
         .mark = SP_MARK_SQUARE,
         .open = true},
        circles(2, q->picked_n, q->picked_square),
        {.n = q->bodies, .x = q->body_n, .y = q->body_square, .ink = 1, .dash = SP_DASH_NONE, .mark = SP_MARK_DIAMOND}};
    const sp_curve squares[2] = {{.n = m->n, .x = q->n, .y = q->square},
                                 circles(PICKED, q->picked_n, q->picked_square)};
    const sp_curve weights[2] = {{.n = m->n, .x = q->n, .y = q->weight, .width = 0.5},
                                 circles(PICKED, q->picked_n, q->picked_weight)};
    const sp_panel inset = {.x = {"|n|", false, NAN, NAN},
                            .y = {"|ω|^{2}  [|E|*/(|ρ d|^{2})]", false, 0, NAN},
                            .curves = 3,
                            .curve = small};
    const sp_panel panel[2] = {{.tag = "(a)",
                                .x = {"mode |n|", false, 0, (double)m->n},
                                .y = {"|ω|_{|n|}^{2}  [|E|*/(|ρ d|^{2})]", false, 0, NAN},
                                .curves = 2,
                                .curve = squares,
                                .inset = &inset},
                               {.tag = "(b)",
                                .x = {"mode |n|", false, 0, (double)m->n},
                                .y = {"|a|_{|n|} |b|_{|n|}  [|E|* |d|^{2}]", false, NAN, NAN},
                                .curves = 2,
                                .curve = weights,
                                .zero_line = true}};
    const sp_sheet sheet = {.title = "Modes", .rows = 2, .columns = 1, .panel = panel};
    return sp_paper_draw(
        s->p, s->item, "fig9", &sheet,
        "(a) Squared eigenfrequencies of the packing of Fig. 1 and (b) weights of the modes in the signal; "
        "circles: the modes of Fig. 10; inset: the lowest (squares) beside those of an elastic body with the packing's "
        "moduli (diamonds).",
        err);
}

static sp_status make_spectrum(const sp_sample *sample, const sp_packing *packing, const sp_network *net, void *user,
                               sp_error *err) {
    (void)packing;
    paper_work *s = user;
    sp_modes m = sp_modes_none();
    points q = {0};
    int64_t picked[PICKED];
    sp_status status = make_modes(net, &m, picked, err);
    if (status == SP_OK)
        status = points_make(&m, picked, &q, err);
    if (status == SP_OK)
        status = add_bodies(s, sample, net, &q, err);
    if (status == SP_OK)
        status = draw_spectrum(s, &m, &q, err);
    if (status == SP_OK)
        sp_paper_say(
            s->p, s->item,
            "%lld of %lld modes have frequency zero, three for each of %d rattlers; the paper's packing had 141. The "
            "lowest frequency above zero is %.4f, the highest %.3f.",
            (long long)m.n_zero, (long long)m.n, net->rattlers, m.omega[m.n_zero], m.omega[m.n - 1]);
    sp_free(q.n);
    sp_modes_free(&m);
    return status;
}

sp_status sp_paper_make_fig9(paper *p, int item, sp_error *err) {
    paper_work s = {p, item};
    return sp_paper_walk(p, PAPER_SQUARE, 1e-4, 0, 1, make_spectrum, &s, err);
}

/* ---- Fig. 10 ---------------------------------------------------------------------------------------------------- */

/* Saves the displacements of the six modes for every grain that is not a rattler. */
static sp_status save_displacements(paper *p, const sp_packing *packing, const sp_network *net, const sp_modes *m,
                                    const int64_t picked[PICKED], sp_error *err) {
    static const char *const column[] = {"mode", "omega", "grain", "x", "y", "u_x", "u_y", "angle"};
    sp_table t = sp_table_none();
    sp_status status = sp_table_add_comment(&t, err, "eigenmodes M^(-1/2) e, e of length 1");
    for (int k = 0; k < 8 && status == SP_OK; k++)
        status = sp_table_add_column(&t, column[k], "", SP_COLUMN_NUMBER, err);
    for (int k = 0; k < PICKED; k++) {
        const double *e = m->vectors + (picked[k] - m->n_rattler) * m->dofs;
        for (int32_t i = 0; i < net->n && status == SP_OK; i++) {
            const double *x = packing->x + 3 * (size_t)net->grain[i];
            const size_t at = (size_t)i * (size_t)net->dof;
            double u[3] = {0};
            for (int d = 0; d < net->dof && d < 3; d++)
                u[d] = e[at + (size_t)d] / sqrt(net->mass[at + (size_t)d]);
            const double row[8] = {(double)picked[k], m->omega[picked[k]], net->grain[i], x[0], x[1], u[0], u[1], u[2]};
            status = sp_table_add_numbers(&t, row, err);
        }
    }
    if (status == SP_OK)
        status = sp_paper_save_table(p, "fig10", &t, err);
    sp_table_free(&t);
    return status;
}

static sp_status draw_mode(const paper_work *s, const sp_packing *packing, const sp_network *net, const sp_modes *m,
                           int64_t number, int letter, sp_error *err) {
    static const char *const why[PICKED] = {"the lowest above zero", "the second above zero",
                                            "strong in the signal",  "strong in the signal",
                                            "strong in the signal",  "localised, among the highest"};
    const double *e = m->vectors + (number - m->n_rattler) * m->dofs;
    char name[32], caption[200], path[SP_PATH_MAX];
    double *u = sp_alloc((size_t)m->dofs, sizeof *u);
    if (!u)
        return sp_fail_memory(err, (size_t)m->dofs * sizeof *u);
    for (int64_t k = 0; k < m->dofs; k++)
        u[k] = e[k] / sqrt(net->mass[k]);
    snprintf(name, sizeof name, "fig10%c", 'a' + letter);
    snprintf(caption, sizeof caption, "(%c) Mode n = %lld, omega = %.4f, participation ratio %.3f: %s.", 'a' + letter,
             (long long)number, m->omega[number], m->participation[number], why[letter]);
    sp_paper_path(s->p, name, s->p->opt->figures, path);
    sp_status status = sp_plot_mode(packing, net, u, number, m->omega[number], path, err);
    sp_free(u);
    if (status == SP_OK)
        sp_paper_add_figure(s->p, s->item, name, caption);
    return status;
}

static sp_status make_six(const sp_sample *sample, const sp_packing *packing, const sp_network *net, void *user,
                          sp_error *err) {
    (void)sample;
    paper_work *s = user;
    sp_modes m = sp_modes_none();
    int64_t picked[PICKED];
    sp_status status = make_modes(net, &m, picked, err);
    for (int k = 0; k < PICKED && status == SP_OK; k++)
        status = draw_mode(s, packing, net, &m, picked[k], k, err);
    if (status == SP_OK)
        status = save_displacements(s->p, packing, net, &m, picked, err);
    if (status == SP_OK) {
        double weight = 0, all = 0;
        for (int64_t k = m.n_zero; k < m.n; k++)
            all += fabs(m.a[k] * m.b[k]);
        for (int64_t k = m.n_zero; k < m.n_zero + 7; k++)
            weight += fabs(m.a[k] * m.b[k]);
        sp_paper_say(
            s->p, s->item,
            "The seven lowest modes above zero carry %.1f%% of the sum of |a_n b_n|. Participation ratios: %.2f and "
            "%.2f for the two lowest, %.2f, %.2f and %.2f for those that carry the signal, %.3f for the localised "
            "one.",
            100 * weight / all, m.participation[picked[0]], m.participation[picked[1]], m.participation[picked[2]],
            m.participation[picked[3]], m.participation[picked[4]], m.participation[picked[5]]);
    }
    sp_modes_free(&m);
    return status;
}

sp_status sp_paper_make_fig10(paper *p, int item, sp_error *err) {
    paper_work s = {p, item};
    return sp_paper_walk(p, PAPER_SQUARE, 1e-4, 0, 1, make_six, &s, err);
}
