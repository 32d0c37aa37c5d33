/* Makes Fig. 3: displacements of the grains at one time. */
#include "base/base.h"
#include "paper/paper.h"

#include <math.h>
#include <sonopack/figure/plot.h>
#include <sonopack/signal.h>
#include <stddef.h>

static const double snapshot_time = 80; /* time in the paper */

static sp_status save_field(paper *p, const sp_packing *packing, const sp_network *net, const double *u,
                            sp_error *err) {
    static const char *const column[] = {"grain", "x", "y", "radius", "u_x", "u_y", "angle"};
    sp_table t = sp_table_none();
    sp_status status = sp_table_set_number(&t, "t", snapshot_time, 6, err);
    for (int k = 0; k < 7 && status == SP_OK; k++)
        status = sp_table_add_column(&t, column[k], "", SP_COLUMN_NUMBER, err);
    for (int32_t i = 0; i < net->n && status == SP_OK; i++) {
        const double *x = packing->x + 3 * (size_t)net->grain[i], *at = u + (size_t)i * (size_t)net->dof;
        const double row[7] = {net->grain[i],           x[0], x[1], packing->r[net->grain[i]], at[0], at[1],
                               net->dof > 2 ? at[2] : 0};
        status = sp_table_add_numbers(&t, row, err);
    }
    if (status == SP_OK)
        status = sp_paper_save_table(p, "fig3", &t, err);
    sp_table_free(&t);
    return status;
}

/* Reports root mean square displacements, in the vertical direction, in each quarter of the height. */
static void say_layers(const paper_work *s, const sp_packing *packing, const sp_network *net, const double *u) {
    enum { PARTS = 4 };
    double sum[PARTS] = {0}, count[PARTS] = {0}, rms[PARTS];
    const double height = sp_packing_height(packing);
    for (int32_t i = 0; i < net->n; i++) {
        const double y = packing->x[3 * (size_t)net->grain[i] + 1], uy = u[(size_t)i * (size_t)net->dof + 1];
        const int part = (int)fmin(PARTS - 1, fmax(0, floor(PARTS * y / height)));
        sum[part] += uy * uy;
        count[part]++;
    }
    for (int k = 0; k < PARTS; k++)
        rms[k] = sqrt(sum[k] / fmax(count[k], 1));
    sp_paper_say(
        s->p, s->item,
        "Root mean square displacements up and down in the four quarters of the height, from the bottom, over that of "
        "the lowest: 1, %.2f, %.2f, %.2f.",
        rms[1] / rms[0], rms[2] / rms[0], rms[3] / rms[0]);
}

static sp_status draw(const sp_sample *sample, const sp_packing *packing, const sp_network *net, void *user,
                      sp_error *err) {
    (void)sample;
    paper_work *s = user;
    const sp_field_options spec = {.source = SP_SOURCE_IMPULSE, .times = 1, .t = &snapshot_time, .threads = 1};
    const size_t dofs = (size_t)sp_network_dofs(net);
    char path[SP_PATH_MAX];
    double *u = sp_alloc(dofs, sizeof *u);
    if (!u)
        return sp_fail_memory(err, dofs * sizeof *u);
    sp_paper_path(s->p, "fig3", s->p->opt->figures, path);
    sp_status status = sp_signal_field(net, &spec, u, NULL, err);
    if (status == SP_OK)
        status = sp_plot_snapshot(packing, net, u, snapshot_time, path, err);
    if (status == SP_OK)
        status = save_field(s->p, packing, net, u, err);
    if (status == SP_OK) {
        sp_paper_add_figure(
            s->p, s->item, "fig3",
            "Displacements of the grains of the packing of Fig. 1 at t = 80 after the pulse at the bottom "
            "wall, magnified; rattlers grey.");
        say_layers(s, packing, net, u);
    }
    sp_free(u);
    return status;
}

sp_status sp_paper_make_fig3(paper *p, int item, sp_error *err) {
    paper_work s = {p, item};
    return sp_paper_walk(p, PAPER_SQUARE, 1e-4, 0, 1, draw, &s, err);
}
