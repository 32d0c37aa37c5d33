/* Reads a packing of another program, stage by stage. */
#include "base/base.h"
#include "base/text.h"
#include "foreign/work.h"
#include "packing/geometry.h"
#include "store/exchange.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

sp_import_options sp_import_options_default(void) {
    return (sp_import_options){.up = -1,
                               .wall = -1,
                               .first_id = -1,
                               .width = NAN,
                               .depth = NAN,
                               .bottom = NAN,
                               .top = NAN,
                               .height = NAN,
                               .cell = -1,
                               .side = {NAN, NAN, NAN, NAN},
                               .tilt = {NAN, NAN, NAN},
                               .gravity = NAN,
                               .pressure = NAN,
                               .friction = NAN,
                               .poisson = NAN,
                               .length_unit = 1,
                               .force_unit = 1,
                               .mass_unit = 1,
                               .kn = NAN,
                               .kt_ratio = NAN,
                               .thickness = NAN};
}

/* ---- keys ------------------------------------------------------------------------------------------------------ */

static const struct number_key {
    const char *name;
    size_t field;
    double low, high;
} number_keys[] = {
    {"width", offsetof(sp_import_options, width), 0, INFINITY},
    {"depth", offsetof(sp_import_options, depth), 0, INFINITY},
    {"height", offsetof(sp_import_options, height), 0, INFINITY},
    {"bottom", offsetof(sp_import_options, bottom), -INFINITY, INFINITY},
    {"top", offsetof(sp_import_options, top), -INFINITY, INFINITY},
    {"left", offsetof(sp_import_options, side[0]), -INFINITY, INFINITY},
    {"right", offsetof(sp_import_options, side[1]), -INFINITY, INFINITY},
    {"front", offsetof(sp_import_options, side[2]), -INFINITY, INFINITY},
    {"back", offsetof(sp_import_options, side[3]), -INFINITY, INFINITY},
    {"xy", offsetof(sp_import_options, tilt[0]), -INFINITY, INFINITY},
    {"xz", offsetof(sp_import_options, tilt[1]), -INFINITY, INFINITY},
    {"yz", offsetof(sp_import_options, tilt[2]), -INFINITY, INFINITY},
    {"gravity", offsetof(sp_import_options, gravity), -INFINITY, INFINITY},
    {"pressure", offsetof(sp_import_options, pressure), 0, INFINITY},
    {"friction", offsetof(sp_import_options, friction), 0, 1e6},
    {"poisson", offsetof(sp_import_options, poisson), 0, 0.5},
};

static sp_status fail_key(const char *name, const char *value, const char *rule, sp_error *err) {
    return sp_fail_key(err, SP_EINVAL, name, " = '%.60s': must be %s", value, rule);
}

static sp_status set_word(sp_import_options *o, const char *name, const char *value, sp_error *err) {
    int64_t whole;
    sp_wall wall;
    sp_cell cell;
    if (strcmp(name, "cell") == 0) {
        if (!sp_cell_read(value, &cell))
            return fail_key(name, value, "piston, periodic or box", err);
        o->cell = (int)cell;
    } else if (strcmp(name, "up") == 0) {
        if (strlen(value) != 1 || value[0] < 'x' || value[0] > 'z')
            return fail_key(name, value, "x, y or z", err);
        o->up = value[0] - 'x';
    } else if (strcmp(name, "sides") == 0) {
        o->open = strcmp(value, "open") == 0;
        if (!o->open && strcmp(value, "periodic") != 0)
            return fail_key(name, value, "open or periodic", err);
    } else if (strcmp(name, "across") == 0) {
        o->cut = strcmp(value, "drop") == 0;
        if (!o->cut)
            return fail_key(name, value, "drop", err);
    } else if (strcmp(name, "digits") == 0) {
        o->exact = strcmp(value, "exact") == 0;
        if (!o->exact)
            return fail_key(name, value, "exact", err);
    } else if (strcmp(name, "wall") == 0) {
        if (!sp_wall_read(value, &wall))
            return fail_key(name, value, "rigid, grain or elastic", err);
        o->wall = (int)wall;
    } else if (strcmp(name, "dimension") == 0) {
        if (strcmp(value, "2") != 0 && strcmp(value, "3") != 0)
            return fail_key(name, value, "2 or 3", err);
        o->dim = value[0] - '0';
    } else if (strcmp(name, "first_id") == 0) {
        if (!sp_word_integer(value, &whole) || whole < 0)
            return fail_key(name, value, "a whole number >= 0", err);
        o->first_id = whole;
    } else {
        return sp_fail(
            err, SP_EINVAL,
            "'%.60s=%.60s': must be key=value with one of the keys dimension, up, cell, sides, across, width, "
            "depth, bottom, top, height, left, right, front, back, xy, xz, yz, gravity, pressure, friction, poisson, "
            "wall, digits, first_id",
            name, value);
    }
    return SP_OK;
}

sp_status sp_import_set(sp_import_options *o, const char *text, sp_error *err) {
    char name[64];
    if (strncmp(text, "packing.", 8) == 0)
        text += 8;
    const size_t length = strcspn(text, "=");
    if (text[length] != '=' || length >= sizeof name)
        return sp_fail(err, SP_EINVAL, "'%.100s': must be key=value", text);
    snprintf(name, sizeof name, "%.*s", (int)length, text);
    const char *value = text + length + 1;
    for (size_t k = 0; k < sizeof number_keys / sizeof *number_keys; k++) {
        const struct number_key *key = &number_keys[k];
        if (strcmp(key->name, name) != 0)
            continue;
        double *field = (double *)(void *)((char *)o + key->field);
        if (!sp_word_number(value, field) || !isfinite(*field) || !(*field >= key->low && *field <= key->high)) {
            *field = NAN;
            return fail_key(name, value, key->low == 0 ? "a finite number >= 0" : "a finite number", err);
        }
        return SP_OK;
    }
    return set_word(o, name, value, err);
}

/* ---- files ----------------------------------------------------------------------------------------------------- */

static sp_status find_form(sp_work *w, sp_error *err) {
    w->form = w->o->form;
    sp_status status = w->form == SP_FORM_AUTO ? sp_form_of_file(w->path, &w->form, err) : SP_OK;
    if (status == SP_OK && (w->form == SP_FORM_AUTO || w->form == SP_FORM_OURS))
        return sp_fail(
            err, SP_EFORMAT,
            "%s: %s; --from must be lammps-data, lammps-dump, liggghts, yade, mercury, xyz, csv or photoelastic",
            w->path, w->form == SP_FORM_OURS ? "a packing of this program" : "its form is not recognised");
    w->report.form = w->form;
    return status;
}

static bool is_word(const char *text, const char *word) { return text && strcmp(text, word) == 0; }

static sp_status read_files(sp_work *w, sp_error *err) {
    const sp_import_options *o = w->o;
    const sp_frame_choice frame = {o->frame_given, o->frame};
    sp_status status = sp_read_form(w->path, w->form, false, frame, &w->grains, err);
    if (status != SP_OK)
        return status;
    if (o->frame_given && w->grains.frame < 0)
        return sp_fail(err, SP_EINVAL, "--frame %lld: %s has no frames", (long long)o->frame, w->path);
    if (w->grains.frames > 1 && !o->frame_given)
        sp_work_note(w, "%s has %d frames: the last, %lld, is taken (--frame takes another)", w->path, w->grains.frames,
                     (long long)w->grains.frame);
    /* of several frames, the contacts of the same one */
    const sp_frame_choice same = {w->grains.frame >= 0, w->grains.frame};
    if (o->contacts && !is_word(o->contacts, "overlap"))
        status = sp_read_form(o->contacts, w->form, true, same, &w->contacts, err);
    const bool words = is_word(o->walls, "overlap") || is_word(o->walls, "none") || is_word(o->walls, "balance");
    if (status == SP_OK && o->walls && !words)
        status = sp_read_form(o->walls, w->form, true, same, &w->walls, err);
    if (status == SP_OK && w->contacts.file && w->contacts.frame >= 0 && w->grains.frame >= 0 &&
        w->contacts.frame != w->grains.frame)
        status = sp_fail(err, SP_EINVAL, "%s is of frame %lld, %s of %lld; must be the same", w->path,
                         (long long)w->grains.frame, o->contacts, (long long)w->contacts.frame);
    return status;
}

/* ---- what the file says ---------------------------------------------------------------------------------------- */

static bool is_open(const sp_import_options *o, const char *key) {
    if (strcmp(key, "wall") == 0)
        return o->wall < 0;
    if (strcmp(key, "dimension") == 0)
        return o->dim == 0;
    if (strcmp(key, "cell") == 0)
        return o->cell < 0;
    for (size_t k = 0; k < sizeof number_keys / sizeof *number_keys; k++)
        if (strcmp(number_keys[k].name, key) == 0)
            return isnan(*(const double *)(const void *)((const char *)o + number_keys[k].field));
    return false;
}

/* Keys in the head of a file, such as `# friction = 0.5' of a table or friction=0.5 of XYZ, count unless they are given
 * by the options. */
static sp_status take_keys(sp_work *w, sp_error *err) {
    static const char *const keys[] = {"dimension", "cell",     "width",   "depth", "height",  "bottom", "top",
                                       "left",      "right",    "front",   "back",  "xy",      "xz",     "yz",
                                       "gravity",   "friction", "poisson", "wall",  "pressure"};
    char taken[400] = "", value[100], text[160];
    size_t used = 0;
    for (size_t k = 0; k < sizeof keys / sizeof *keys; k++) {
        if (!is_open(&w->own, keys[k]) || !sp_sheet_said(&w->grains, keys[k], value, sizeof value))
            continue;
        snprintf(text, sizeof text, "%s=%s", keys[k], value);
        if (sp_import_set(&w->own, text, err) != SP_OK)
            return sp_fail_prefix(err, "%s", w->path);
        used += (size_t)snprintf(taken + used, used < sizeof taken ? sizeof taken - used : 0, " %s", text);
        used = used < sizeof taken ? used : sizeof taken - 1;
    }
    if (used > 0)
        sp_work_note(w, "from the head of the file:%s", taken);
    return SP_OK;
}

/* ---- options that need each other ------------------------------------------------------------------------------ */

static sp_status check_options(const sp_work *w, sp_error *err) {
    const sp_import_options *o = w->o;
    const bool si = o->material.young > 0;
    const double positive[] = {o->length_unit, o->force_unit, o->mass_unit};
    for (int k = 0; k < 3; k++)
        if (!(positive[k] > 0) || !isfinite(positive[k]))
            return sp_fail(err, SP_EINVAL, "the unit %g: must be positive", positive[k]);
    if (!si && isfinite(o->thickness))
        return sp_fail(err, SP_EINVAL, "--thickness: needs the density of the disks, --material E=...,nu=...,rho=...");
    if (w->form != SP_FORM_PHOTOELASTIC)
        return SP_OK;
    if (!si || !isfinite(o->kn))
        return sp_fail(err, SP_EINVAL, "photoelastic disks are no Hertzian spheres: give %s",
                       !si ? "--material E=...,nu=...,rho=... (their modulus and density)"
                           : "--kn, the stiffness of a contact");
    if (!o->contacts)
        return sp_fail(err, SP_EINVAL, "photoelastic: give --contacts, the file of frame,id1,id2,Ft,Fn");
    return SP_OK;
}

/* ---- import ---------------------------------------------------------------------------------------------------- */

static sp_status read_contacts(sp_work *w, sp_error *err) {
    const bool listed = w->contacts.file != NULL;
    sp_status status = listed ? sp_read_links(w, err) : sp_touch_grains(w, err);
    if (status == SP_OK && w->report.across > 0)
        sp_work_note(w, "%lld contacts across the face of the box along %c are left out", (long long)w->report.across,
                     "xyz"[w->axis[w->dim - 1]]);
    if (status == SP_OK && !listed)
        sp_work_note(w, "contacts: all pairs that overlap");
    return status == SP_OK ? sp_read_walls(w, err) : status;
}

static sp_status run(sp_work *w, sp_packing *out, sp_error *err) {
    sp_status status = find_form(w, err);
    if (status == SP_OK)
        status = check_options(w, err);
    if (status == SP_OK)
        status = sp_roles_read(w, err);
    if (status == SP_OK)
        status = read_files(w, err);
    if (status == SP_OK)
        status = take_keys(w, err);
    if (status == SP_OK)
        status = sp_gather_grains(w, err);
    if (status == SP_OK)
        status = sp_scale_grains(w, err);
    if (status == SP_OK)
        status = sp_box_find(w, err);
    if (status == SP_OK)
        status = read_contacts(w, err);
    if (status == SP_OK)
        status = sp_roles_check(w, err);
    if (status == SP_OK)
        status = sp_law_complete(w, err);
    if (status == SP_OK)
        status = sp_finish(w, out, err);
    if (status == SP_OK && w->o->rest && (status = sp_bring_to_rest(w, out, err)) != SP_OK)
        sp_packing_free(out);
    return status;
}

sp_status sp_import(const char *path, const sp_import_options *o, sp_packing *out, sp_import_report *report,
                    sp_error *err) {
    sp_work *w = sp_alloc(1, sizeof *w);
    sp_packing p = sp_packing_none();
    if (!w)
        return sp_fail_memory(err, sizeof *w);
    w->path = path;
    w->own = *o;
    w->o = &w->own;
    w->force_place = w->report.hertz = w->report.hertz_spread = w->report.overlap_error = NAN;
    sp_locale locale = sp_locale_enter();
    sp_status status = run(w, &p, err);
    sp_locale_leave(&locale);
    sp_sheet_free(&w->grains);
    sp_sheet_free(&w->contacts);
    sp_sheet_free(&w->walls);
    sp_free(w->grain);
    sp_free(w->contact);
    if (status == SP_OK && report)
        *report = w->report;
    if (status == SP_OK)
        *out = p;
    sp_free(w);
    return status;
}
