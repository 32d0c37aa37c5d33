/* Draws modes and snapshots: computed, or read from a file of modes or a table of displacements. */
#include "cli/plot_motion.h"

#include "base/base.h"
#include "cli/files.h"
#include "cli/motion.h"
#include "cli/plot_frames.h"
#include "cli/plot_input.h"
#include "cli/trace.h"

#include <math.h>
#include <sonopack/study/modes_file.h>

/* What is drawn, and its memory. */
typedef struct drawing {
    const cli_common *common;
    const sp_scene *scene;
    const plot_motion *what;
    sp_packing packing;
    sp_network net;
    double *u; /* [frames, or 1][degrees of freedom] */
    double *t; /* [frames] times of a movie of snapshots, else NULL */
    cli_motion motion;
} drawing;

/* Messages of functions that do not know the file name it here. */
static sp_status of_packing(const drawing *d, sp_status status, sp_error *err) {
    return status == SP_OK ? SP_OK : sp_fail_prefix(err, "%s", d->what->packing);
}

/* Makes the network of the packing, and room for the displacements. */
static sp_status make_network(drawing *d, const sp_network_options *options, sp_error *err) {
    const sp_status status = of_packing(d, sp_network_make(&d->packing, options, &d->net, err), err);
    if (status != SP_OK)
        return status;
    d->motion.made = *options;
    const size_t fields = d->what->frames > 0 && !d->what->mode ? (size_t)d->what->frames : 1;
    const size_t room = (size_t)sp_network_dofs(&d->net) * sizeof *d->u;
    d->u = sp_alloc(fields, room);
    return d->u ? SP_OK : sp_fail_memory(err, fields * room);
}

/* ---- modes ------------------------------------------------------------------------------------------------------ */

/* Finds the row of the wanted mode. `modes' may be a part of the spectrum. */
static sp_status find_row(const drawing *d, const sp_modes *m, int64_t *row, sp_error *err) {
    const int64_t number = d->what->number;
    *row = number < 0 ? m->n_zero : number - m->first;
    if (m->n == 0)
        return sp_fail(err, SP_EREFUSED, "there are no modes in it");
    if (number < 0 && m->n == m->n_zero)
        return sp_fail(err, SP_EREFUSED, "there are only zero modes");
    if (*row < 0 || *row >= m->n)
        return sp_fail(err, SP_EINVAL, "--mode %lld: must be in %lld .. %lld", (long long)number,
                       (long long)(m->first + m->n_rattler), (long long)(m->first + m->n) - 1);
    if (*row < m->n_rattler)
        return sp_fail(err, SP_EREFUSED, "mode %lld belongs to a rattler: must be %lld or more", (long long)number,
                       (long long)(m->first + m->n_rattler));
    return SP_OK;
}

static void describe_mode(drawing *d, const sp_modes *m, int64_t row) {
    d->motion.number = m->first + row;
    d->motion.omega = m->omega[row];
    d->motion.omega_error = m->error[row];
    d->motion.error = sp_modes_vector_error(m, &d->net, row);
}

/* Finds the modes up to the wanted one, or the first that is not a zero mode. */
static sp_status find_modes(const drawing *d, sp_modes *m, sp_error *err) {
    const sp_modes_options o = sp_modes_options_default();
    const sp_modes_range all = sp_modes_range_all();
    const int64_t number = d->what->number, rattlers = (int64_t)d->net.rattlers * d->net.dof;
    sp_modes_range range = sp_modes_range_lowest(number < rattlers ? 1 : number - rattlers + 1);
    sp_error reason = {0};
    range.zero = number >= 0;
    const bool too_many = range.lowest > sp_network_dofs(&d->net);
    const sp_status status = too_many ? SP_EINVAL : sp_modes_make(&d->net, &o, &range, m, &reason);
    if (status == SP_EINVAL && number >= 0) /* there are not so many besides zero modes */
        return sp_modes_make(&d->net, &o, &all, m, err);
    if (status == SP_EINVAL)
        return sp_fail(err, SP_EREFUSED, "there are only zero modes");
    return status == SP_OK ? SP_OK : sp_fail(err, status, "%s", reason.text);
}

static sp_status compute_mode(drawing *d, sp_error *err) {
    sp_modes m = sp_modes_none();
    int64_t row = 0;
    sp_status status = make_network(d, &d->scene->network, err);
    if (status == SP_OK)
        status = of_packing(d, find_modes(d, &m, err), err);
    if (status == SP_OK)
        status = of_packing(d, find_row(d, &m, &row, err), err);
    if (status == SP_OK) {
        cli_motion_of_mode(&d->net, m.vectors + (row - m.n_rattler) * m.dofs, d->u);
        describe_mode(d, &m, row);
    }
    sp_modes_free(&m);
    return status;
}

static sp_status check_grains(const drawing *d, const sp_modes_file *f, sp_error *err) {
    bool same = f->n == d->net.n && f->dof == d->net.dof;
    for (int32_t k = 0; same && k < f->n; k++)
        same = f->grain[k] == d->net.grain[k];
    return same ? SP_OK
                : sp_fail(err, SP_EFORMAT, "%s: the modes have other grains or degrees of freedom than the network",
                          d->what->given);
}

static sp_status read_mode(drawing *d, sp_error *err) {
    sp_modes_file f = sp_modes_file_none();
    double *e = NULL;
    int64_t row = 0;
    sp_status status = sp_modes_file_read(d->what->given, &d->packing, &f, err);
    if (status == SP_OK)
        status = make_network(d, &f.made.network, err);
    if (status == SP_OK)
        status = check_grains(d, &f, err);
    if (status == SP_OK && (status = find_row(d, &f.modes, &row, err)) != SP_OK)
        sp_fail_prefix(err, "%s", d->what->given);
    if (status == SP_OK) {
        e = sp_alloc((size_t)f.modes.dofs, sizeof *e);
        status = e ? sp_modes_file_vectors(d->what->given, &f, row, 1, e, err)
                   : sp_fail_memory(err, (size_t)f.modes.dofs * sizeof *e);
    }
    if (status == SP_OK) {
        cli_motion_of_mode(&d->net, e, d->u);
        describe_mode(d, &f.modes, row);
    }
    sp_free(e);
    sp_modes_file_free(&f);
    return status;
}

/* ---- snapshots and tables --------------------------------------------------------------------------------------- */

/* The displacements of all frames, in one pass. usual: when the wave is about three quarters of the way. */
static sp_status compute_frames(drawing *d, double usual, sp_error *err) {
    const int frames = d->what->frames;
    const double from = fmax(0, d->what->from), to = d->what->to >= 0 ? d->what->to : usual / 0.75;
    if (!(from < to))
        return sp_fail(err, SP_EINVAL, "--from %g: must be before the last frame, at %g (--to)", from, to);
    double *errors = sp_alloc((size_t)frames, sizeof *errors);
    d->t = sp_alloc((size_t)frames, sizeof *d->t);
    sp_status status = errors && d->t ? SP_OK : sp_fail_memory(err, (size_t)frames * sizeof *errors);
    for (int k = 0; k < frames && status == SP_OK; k++)
        d->t[k] = from + (to - from) * k / (frames - 1);
    d->motion.source = d->scene->signal.source;
    const sp_field_options spec = {
        .source = d->motion.source, .times = frames, .t = d->t, .threads = d->common->threads};
    if (status == SP_OK)
        status = of_packing(d, sp_signal_field(&d->net, &spec, d->u, errors, err), err);
    sp_free(errors);
    return status;
}

static sp_status compute_snapshot(drawing *d, sp_error *err) {
    sp_status status = make_network(d, &d->scene->network, err);
    if (status == SP_OK)
        status = of_packing(d, cli_need_walls(&d->packing, "the pulse of a snapshot", err), err);
    if (status != SP_OK)
        return status;
    /* 80 at a height of 25 and p = 1e-4, as in Fig. 3 of Somfai et al. 2005 */
    const double pressure = d->packing.pressure, height = sp_packing_height(&d->packing);
    const double usual = 3.2 * height * pow(pressure / 1e-4, -1.0 / 6);
    if (d->what->frames > 0)
        return compute_frames(d, usual, err);
    d->motion.t = d->what->time >= 0 ? d->what->time : usual;
    d->motion.source = d->scene->signal.source;
    const sp_field_options spec = {
        .source = d->motion.source, .times = 1, .t = &d->motion.t, .threads = d->common->threads};
    status = of_packing(d, sp_signal_field(&d->net, &spec, d->u, &d->motion.error, err), err);
    if (status == SP_OK)
        cli_debug(d->common, "displacements at t = %.6g, with errors of at most %.2g", d->motion.t, d->motion.error);
    return status;
}

static sp_status read_table(drawing *d, sp_error *err) {
    const char *path = d->what->given;
    sp_table t = sp_table_none();
    sp_status status = plot_read_table(path, &t, err);
    if (status == SP_OK)
        status = cli_motion_head(path, &d->packing, &t, &d->motion, err);
    if (status == SP_OK) {
        const sp_network_options made = d->motion.made;
        status = make_network(d, &made, err);
    }
    if (status == SP_OK)
        status = cli_motion_field(path, &d->net, &t, d->u, err);
    if (status == SP_OK && d->what->mode && d->what->number >= 0 && d->what->number != d->motion.number)
        status = sp_fail(err, SP_EINVAL, "--mode %lld: %s has mode %lld", (long long)d->what->number, path,
                         (long long)d->motion.number);
    sp_table_free(&t);
    return status;
}

/* ---- the figure ------------------------------------------------------------------------------------------------- */

static sp_status find_motion(drawing *d, sp_error *err) {
    bool binary = false;
    sp_status status = sp_packing_read(d->what->packing, &d->packing, err);
    if (status != SP_OK)
        return status;
    d->motion.packing = &d->packing;
    d->motion.net = &d->net;
    d->motion.mode = d->what->mode;
    if (d->what->given)
        status = cli_is_packing(d->what->given, &binary, err);
    if (status == SP_OK && binary && !d->what->mode)
        status = sp_fail(err, SP_EINVAL, "plot snapshot: 2 files, %s must be a table of displacements", d->what->given);
    if (status == SP_OK && d->what->given)
        status = binary && d->what->mode ? read_mode(d, err) : read_table(d, err);
    else if (status == SP_OK)
        status = d->what->mode ? compute_mode(d, err) : compute_snapshot(d, err);
    d->motion.u = d->u;
    return status;
}

static sp_status draw_snapshots(const drawing *d, char **path, sp_error *err) {
    const int frames = d->what->frames;
    const int64_t dofs = sp_network_dofs(&d->net);
    sp_plot_frame *frame = sp_alloc((size_t)frames, sizeof *frame);
    if (!frame)
        return sp_fail_memory(err, (size_t)frames * sizeof *frame);
    for (int k = 0; k < frames; k++)
        frame[k] = (sp_plot_frame){.t = d->t[k], .u = d->u + k * dofs, .path = path[k]};
    const sp_status status = sp_plot_snapshot_frames(&d->packing, &d->net, frames, frame, err);
    sp_free(frame);
    return status;
}

static sp_status draw_frames(const drawing *d, sp_error *err) {
    const cli_motion *m = &d->motion;
    char **path = NULL;
    sp_status status = plot_frame_paths(d->common->output, d->what->frames, &path, err);
    if (status != SP_OK)
        return status;
    if (m->mode)
        status = sp_plot_mode_frames(m->packing, m->net, m->u, m->number, m->omega, d->what->frames,
                                     (const char *const *)path, err);
    else
        status = draw_snapshots(d, path, err);
    sp_free(path);
    return of_packing(d, status, err);
}

static sp_status draw(const drawing *d, sp_error *err) {
    const cli_motion *m = &d->motion;
    if (d->what->frames > 0)
        return draw_frames(d, err);
    const char *path = d->common->output;
    sp_status status = d->what->table ? cli_motion_write(d->common, m, d->what->table, err) : SP_OK;
    if (status != SP_OK)
        return status;
    status = m->mode ? sp_plot_mode(m->packing, m->net, m->u, m->number, m->omega, path, err)
                     : sp_plot_snapshot(m->packing, m->net, m->u, m->t, path, err);
    return of_packing(d, status, err);
}

sp_status plot_motion_file(const cli_common *common, const sp_scene *scene, const plot_motion *what, sp_error *err) {
    drawing d = {
        .common = common, .scene = scene, .what = what, .packing = sp_packing_none(), .net = sp_network_none()};
    sp_status status = find_motion(&d, err);
    if (status == SP_OK)
        status = draw(&d, err);
    sp_free(d.u);
    sp_free(d.t);
    sp_network_free(&d.net);
    sp_packing_free(&d.packing);
    return status;
}

/* ---- without a figure ------------------------------------------------------------------------------------------- */

plot_motion_found plot_motion_none(void) {
    return (plot_motion_found){.packing = sp_packing_none(), .net = sp_network_none()};
}

sp_status plot_motion_find(const cli_common *common, const sp_scene *scene, const plot_motion *what,
                           plot_motion_found *out, sp_error *err) {
    drawing d = {
        .common = common, .scene = scene, .what = what, .packing = sp_packing_none(), .net = sp_network_none()};
    const sp_status status = find_motion(&d, err);
    *out = (plot_motion_found){.packing = d.packing, .net = d.net, .u = d.u, .motion = d.motion};
    out->motion.packing = &out->packing;
    out->motion.net = &out->net;
    return status;
}

void plot_motion_free(plot_motion_found *found) {
    sp_free(found->u);
    sp_network_free(&found->net);
    sp_packing_free(&found->packing);
    *found = plot_motion_none();
}
