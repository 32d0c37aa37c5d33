/* Writes the files of other programs for sonopack convert. */
#include "cli/convert_out.h"

#include "base/base.h"
#include "cli/files.h"
#include "cli/output.h"
#include "cli/plot_input.h"
#include "cli/plot_motion.h"
#include "cli/trace.h"
#include "packing/geometry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define AMPLITUDE 0.25 /* default of --amplitude [d] */
enum { FRAMES = 24 };  /* default of --frames */
static const char pvd[] = ".pvd";

/* ---- the form --------------------------------------------------------------------------------------------------- */

/* Words of --to that are no forms of export. */
static const struct { const char *word, *ending; } own_forms[] = {{"h5", ".h5"}, {"txt", ".txt"}, {"pvd", pvd}};
enum { OWN_FORMS = sizeof own_forms / sizeof *own_forms };

static const char *form_word(int k, const void *user) {
    (void)user;
    return k < OWN_FORMS ? own_forms[k].word : sp_export_form_name(k - OWN_FORMS);
}

sp_status convert_out_ending(const convert_out *o, const char *path, const char **ending, sp_error *err) {
    *ending = NULL;
    for (int k = 0; o->to && form_word(k, NULL); k++)
        if (strcmp(o->to, form_word(k, NULL)) == 0)
            *ending = k < OWN_FORMS ? own_forms[k].ending : sp_export_form_ending(k - OWN_FORMS);
    if (o->to && !*ending)
        return sp_fail(err, SP_EINVAL,
                       "--to %.60s: must be h5, txt, pvd, vtp, lammps-data, lammps-dump, xyz, csv or mat", o->to);
    for (int k = 0; !o->to && k < OWN_FORMS; k++)
        if (cli_has_ending(path, own_forms[k].ending))
            *ending = own_forms[k].ending;
    if (!o->to && cli_is_hdf5(path))
        *ending = own_forms[0].ending;
    if (!*ending)
        *ending = sp_export_form_ending((int)sp_export_form_of(path));
    return SP_OK;
}

bool convert_out_is_foreign(const char *ending) {
    return ending && strcmp(ending, own_forms[0].ending) != 0 && strcmp(ending, own_forms[1].ending) != 0;
}

static sp_export_form form_of(const char *ending) {
    int k = 0;
    while (sp_export_form_ending(k) && strcmp(ending, sp_export_form_ending(k)) != 0)
        k++;
    return (sp_export_form)k;
}

static bool is_series(const char *ending) { return strcmp(ending, pvd) == 0; }

/* ---- options ---------------------------------------------------------------------------------------------------- */

/* T, or LOW:HIGH:N. */
static sp_status read_times(const char *text, int *n, double **out, sp_error *err) {
    char low[64], high[64], count[32], rest;
    double from, to;
    int64_t number = 1;
    const int words = sscanf(text, "%63[^:]:%63[^:]:%31[^:]%c", low, high, count, &rest);
    if (words != 1 && words != 3)
        return sp_fail(err, SP_EINVAL, "--times %.60s: must be T or LOW:HIGH:N", text);
    sp_status status = cli_number("--times", low, 0, 1e9, &from, err);
    to = from;
    if (status == SP_OK && words == 3)
        status = cli_number("--times", high, from, 1e9, &to, err);
    if (status == SP_OK && words == 3)
        status = cli_integer("--times", count, 1, SP_EXPORT_FRAMES_MAX, &number, err);
    if (status != SP_OK)
        return status;
    double *t = sp_alloc((size_t)number, sizeof *t);
    if (!t)
        return sp_fail_memory(err, (size_t)number * sizeof *t);
    for (int64_t k = 0; k < number; k++)
        t[k] = number > 1 ? from + (to - from) * (double)k / (double)(number - 1) : from;
    *n = (int)number;
    *out = t;
    return SP_OK;
}

static bool has_motion(const convert_out *o) { return o->vectors || o->mode >= 0 || o->times; }

static sp_status check_options(const convert_out *o, const char *ending, sp_error *err) {
    double *t = NULL;
    int n = 1;
    sp_status status = o->times ? read_times(o->times, &n, &t, err) : SP_OK;
    sp_free(t);
    if (status != SP_OK)
        return status;
    if (o->times && (o->vectors || o->mode >= 0))
        return sp_fail(err, SP_EINVAL,
                       "--times: gives the motion after a pulse; not together with --vectors or --mode");
    if (!is_series(ending) && n > 1)
        return sp_fail(err, SP_EINVAL, "--times %.60s: several times need an OUT that ends in .pvd", o->times);
    if (!is_series(ending) && (o->frames > 0 || o->amplitude >= 0))
        return sp_fail(err, SP_EINVAL, "--%s: applies only to an OUT that ends in .pvd",
                       o->frames > 0 ? "frames" : "amplitude");
    if (o->times && o->frames > 0)
        return sp_fail(err, SP_EINVAL, "--frames: applies only to a mode; --times has its own number");
    return SP_OK;
}

static int count_frames(const convert_out *o) {
    sp_error ignored;
    double *t = NULL;
    int n = o->frames > 0 ? (int)o->frames : FRAMES;
    if (o->times)
        read_times(o->times, &n, &t, &ignored);
    sp_free(t);
    return n;
}

static sp_status check_series(const cli_common *common, const convert_out *o, const char *path, sp_error *err) {
    char name[SP_EXPORT_PATH_MAX];
    sp_status status = cli_may_write_as(common, path, pvd, err);
    for (int k = 0; k < count_frames(o) && status == SP_OK; k++) {
        sp_export_frame_name(path, k, name);
        status =
            name[0] ? cli_may_write(common, name, err) : sp_fail(err, SP_EINVAL, "%.100s: the name is too long", path);
    }
    return status;
}

sp_status convert_out_check(const cli_common *common, const convert_out *o, const char *ending, const char *path,
                            sp_error *err) {
    if (!convert_out_is_foreign(ending)) {
        if (has_motion(o) || o->frames > 0 || o->amplitude >= 0)
            return sp_fail(err, SP_EINVAL,
                           "%s: takes no displacements; the forms .vtp, .pvd, .dump, .xyz, .csv and "
                           ".mat do",
                           path);
        return cli_may_write_as(common, path, ending, err);
    }
    sp_status status = check_options(o, ending, err);
    if (status == SP_OK && is_series(ending))
        return check_series(common, o, path, err);
    char name[SP_EXPORT_FILES_MAX][SP_EXPORT_PATH_MAX];
    const int files = sp_export_files(form_of(ending), path, name);
    if (status == SP_OK && files == 0)
        status = sp_fail(err, SP_EINVAL, "%.100s: the name is too long", path);
    for (int k = 0; k < files && status == SP_OK; k++)
        status = k == 0 ? cli_may_write_as(common, name[0], ending, err) : cli_may_write(common, name[k], err);
    return status;
}

/* ---- units ------------------------------------------------------------------------------------------------------ */

/* What displacements, rotations and times are multiplied by. */
typedef struct factors {
    const sp_material *si; /* of --units si; NULL: own units */
    double length, time, displacement, rotation;
} factors;

/* A mode has |M^(1/2) u| = 1, so that its u is in 1/sqrt(rho d^3) and its rotations in 1/sqrt(rho d^5). */
static factors find_factors(const cli_common *common, const sp_packing *p, bool mode) {
    const sp_material *m = &p->material;
    factors f = {NULL, 1, 1, 1, 1};
    if (common->units != CLI_UNITS_SI)
        return f;
    f.si = m;
    f.length = m->diameter;
    f.time = m->diameter * sqrt(m->density / sp_material_modulus(m));
    f.displacement = mode ? 1 / sqrt(m->density * pow(m->diameter, 3)) : m->diameter;
    f.rotation = f.displacement / m->diameter;
    return f;
}

/* ---- displacements ---------------------------------------------------------------------------------------------- */

/* Spreads a vector of the network over the grains of the packing; rattlers do not move. */
static void spread(const sp_network *net, const double *u, double factor, const factors *f, double *displacement,
                   double *rotation) {
    memset(displacement, 0, 3 * (size_t)net->n_all * sizeof *displacement);
    if (rotation)
        memset(rotation, 0, 3 * (size_t)net->n_all * sizeof *rotation);
    for (size_t k = 0; k < (size_t)net->n; k++) {
        const size_t i = 3 * (size_t)net->grain[k];
        for (int a = 0; a < net->dof; a++) {
            const double value = factor * u[k * (size_t)net->dof + (size_t)a];
            if (a < net->dim)
                displacement[i + (size_t)a] = f->displacement * value;
            else if (rotation)
                rotation[i + (size_t)(net->dim == 2 ? 2 : a - net->dim)] = f->rotation * value;
        }
    }
}

/* Whether a file of --vectors has modes; else it is a table of a snapshot. */
static sp_status find_kind(const char *path, bool *mode, sp_error *err) {
    sp_table t = sp_table_none();
    sp_status status = cli_is_packing(path, mode, err);
    if (status != SP_OK || *mode)
        return status;
    status = plot_read_table(path, &t, err);
    const char *motion = status == SP_OK ? sp_table_get_text(&t, "motion") : NULL;
    *mode = motion && strcmp(motion, "mode") == 0;
    sp_table_free(&t);
    return status;
}

/* The motion that the options select. */
static sp_status find_motion(const cli_common *common, const convert_out *o, const char *in, plot_motion_found *out,
                             sp_error *err) {
    sp_scene scene = sp_scene_default();
    plot_motion what = {.mode = !o->times, .number = o->mode, .time = -1, .packing = in, .given = o->vectors};
    double *t = NULL;
    int n;
    sp_status status = !in ? sp_fail(err, SP_EINVAL, "displacements need a packing file as IN: convert to .h5 first")
                       : o->vectors ? find_kind(o->vectors, &what.mode, err)
                       : o->times   ? read_times(o->times, &n, &t, err)
                                    : SP_OK;
    if (t)
        what.time = t[0];
    if (status == SP_OK)
        status = plot_motion_find(common, &scene, &what, out, err);
    sp_free(t);
    sp_scene_free(&scene);
    return status;
}

static sp_status write_packing(const cli_common *common, const convert_out *o, const char *ending, const sp_packing *p,
                               const plot_motion_found *m, const char *path, sp_error *err) {
    const sp_export_form form = form_of(ending);
    const factors f = find_factors(common, p, m->motion.mode);
    sp_export_options options = {.si = f.si};
    if (!has_motion(o))
        return sp_export(p, form, &options, path, err);
    const bool turns = m->net.dof > m->net.dim;
    const size_t size = 3 * (size_t)p->n;
    double *u = sp_alloc(2 * size, sizeof *u);
    if (!u)
        return sp_fail_memory(err, 2 * size * sizeof *u);
    const sp_grain_vectors v = {.displacement = u, .rotation = turns ? u + size : NULL};
    spread(&m->net, m->u, 1, &f, u, turns ? u + size : NULL);
    options.vectors = &v;
    const sp_status status = sp_export(p, form, &options, path, err);
    sp_free(u);
    return status;
}

/* ---- moving pictures -------------------------------------------------------------------------------------------- */

/* Frames of a mode, u cos(2 pi k/frames), or of a wave, u[k]. */
typedef struct movie {
    const sp_network *net;
    const double *u;
    bool mode;
    int frames;
    factors units;
} movie;

static void make_frame(void *user, int k, double *displacement, double *rotation) {
    const movie *m = user;
    const double phase = 2 * M_PI * k / m->frames;
    spread(m->net, m->mode ? m->u : m->u + (int64_t)k * sp_network_dofs(m->net), m->mode ? cos(phase) : 1, &m->units,
           displacement, rotation);
}

/* The largest displacement of a grain in `count` vectors of the network. */
static double largest(const sp_network *net, const double *u, int count) {
    double most = 0;
    for (int64_t k = 0; k < (int64_t)net->n * count; k++) {
        double sum = 0;
        for (int a = 0; a < net->dim; a++)
            sum += u[k * net->dof + a] * u[k * net->dof + a];
        most = fmax(most, sum);
    }
    return sqrt(most);
}

static sp_status write_movie(const cli_common *common, const convert_out *o, const sp_packing *p, const movie *m,
                             double *time, const char *path, sp_error *err) {
    const double most = m->units.displacement * largest(m->net, m->u, m->mode ? 1 : m->frames);
    const double shown = m->units.length * (o->amplitude >= 0 ? o->amplitude : AMPLITUDE);
    for (int k = 0; k < m->frames; k++)
        time[k] *= m->units.time;
    const sp_export_series series = {.frames = m->frames,
                                     .time = time,
                                     .scale = most > 0 ? shown / most : 0,
                                     .si = m->units.si,
                                     .frame = make_frame,
                                     .rotations = m->net->dof > m->net->dim,
                                     .user = (void *)m};
    const sp_status status = sp_export_pvd(p, &series, path, err);
    if (status == SP_OK)
        cli_note(common, "%s: %d frames, displacements times %.6g", path, m->frames, series.scale);
    return status;
}

static sp_status write_mode(const cli_common *common, const convert_out *o, const sp_packing *p,
                            const plot_motion_found *found, const char *path, sp_error *err) {
    const movie m = {.net = &found->net,
                     .u = found->u,
                     .mode = true,
                     .frames = count_frames(o),
                     .units = find_factors(common, p, true)};
    if (!found->motion.mode)
        return sp_fail(err, SP_EINVAL, "%s: is a snapshot; a movie needs a mode, or --times LOW:HIGH:N", o->vectors);
    const double period = found->motion.omega > 0 ? 2 * M_PI / found->motion.omega : 1;
    double *time = sp_alloc((size_t)m.frames, sizeof *time);
    if (!time)
        return sp_fail_memory(err, (size_t)m.frames * sizeof *time);
    for (int k = 0; k < m.frames; k++)
        time[k] = period * k / m.frames;
    const sp_status status = write_movie(common, o, p, &m, time, path, err);
    sp_free(time);
    return status;
}

static sp_status write_wave(const cli_common *common, const convert_out *o, const sp_packing *p, const char *path,
                            sp_error *err) {
    const sp_network_options options = sp_network_options_default();
    sp_network net = sp_network_none();
    double *time = NULL, *u = NULL;
    int n = 0;
    sp_status status = cli_need_walls(p, "the pulse of --times", err);
    if (status == SP_OK)
        status = read_times(o->times, &n, &time, err);
    if (status == SP_OK)
        status = sp_network_make(p, &options, &net, err);
    if (status == SP_OK) {
        const size_t size = (size_t)n * (size_t)sp_network_dofs(&net);
        u = sp_alloc(size, sizeof *u);
        status = u ? SP_OK : sp_fail_memory(err, size * sizeof *u);
    }
    const sp_field_options field = {.times = n, .t = time, .threads = common->threads};
    if (status == SP_OK)
        status = sp_signal_field(&net, &field, u, NULL, err);
    const movie m = {.net = &net, .u = u, .frames = n, .units = find_factors(common, p, false)};
    if (status == SP_OK)
        status = write_movie(common, o, p, &m, time, path, err);
    sp_free(u);
    sp_free(time);
    sp_network_free(&net);
    return status;
}

/* Says what a form that only knows grains leaves out. */
static void note_losses(const cli_common *common, const char *ending, const sp_packing *p, const char *path) {
    const bool dump = strcmp(ending, ".dump") == 0, data = strcmp(ending, ".data") == 0;
    if (!dump && !data && strcmp(ending, ".xyz") != 0)
        return;
    if (sp_packing_has_stiffnesses(p))
        cli_note(common, "%s: has no place for the stiffnesses of contacts, which are left out", path);
    if (dump && p->cell == SP_CELL_PERIODIC)
        cli_note(common, "%s: has no place for friction: to read it again, --set friction=%g", path, p->friction);
    else if (dump)
        cli_note(common, "%s: has no place for walls and friction: to read it again, --set wall=%s --set friction=%g",
                 path, sp_wall_names[p->wall], p->friction);
}

sp_status convert_out_write(const cli_common *common, const convert_out *o, const char *ending, const sp_packing *p,
                            const char *in, const char *path, sp_error *err) {
    if (is_series(ending) && o->times)
        return write_wave(common, o, p, path, err);
    plot_motion_found found = plot_motion_none();
    sp_status status = has_motion(o) || is_series(ending) ? find_motion(common, o, in, &found, err) : SP_OK;
    if (status == SP_OK)
        status = is_series(ending) ? write_mode(common, o, p, &found, path, err)
                                   : write_packing(common, o, ending, p, &found, path, err);
    plot_motion_free(&found);
    if (status == SP_OK)
        note_losses(common, ending, p, path);
    return status;
}
