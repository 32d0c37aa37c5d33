/* Writes packings in the forms of other programs. */
#include "foreign/export.h"

#include "base/base.h"
#include "base/file.h"

#include <math.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

/* Files of a form beside the first: what replaces the ending. */
static const struct form {
    const char *name, *ending;
    sp_export_writer write;
    const char *beside[SP_EXPORT_FILES_MAX - 1];
    bool vectors; /* whether it has a place for them */
} forms[] = {[SP_EXPORT_VTP] = {"vtp", ".vtp", sp_export_vtp, {"-contacts.vtp", "-walls.vtp", ".vtm"}, true},
             [SP_EXPORT_LAMMPS_DATA] = {"lammps-data", ".data", sp_export_lammps_data, {NULL}, false},
             [SP_EXPORT_LAMMPS_DUMP] = {"lammps-dump", ".dump", sp_export_lammps_dump, {NULL}, true},
             [SP_EXPORT_XYZ] = {"xyz", ".xyz", sp_export_xyz, {NULL}, true},
             [SP_EXPORT_CSV] = {"csv", ".csv", sp_export_csv, {"-contacts.csv"}, true},
             [SP_EXPORT_MAT] = {"mat", ".mat", sp_export_mat, {NULL}, true}};
enum { FORMS = sizeof forms / sizeof *forms };

/* ---- names ------------------------------------------------------------------------------------------------------ */

const char *sp_export_form_name(int form) { return form >= 0 && form < FORMS ? forms[form].name : NULL; }
const char *sp_export_form_ending(int form) { return form >= 0 && form < FORMS ? forms[form].ending : NULL; }

sp_export_form sp_export_form_of(const char *path) {
    static const struct {
        const char *ending;
        sp_export_form form;
    } others[] = {{".lammps", SP_EXPORT_LAMMPS_DATA}, {".extxyz", SP_EXPORT_XYZ}};
    const char *ending = sp_export_ending(path);
    for (int k = 0; k < FORMS; k++)
        if (strcasecmp(ending, forms[k].ending) == 0)
            return (sp_export_form)k;
    for (size_t k = 0; k < sizeof others / sizeof *others; k++)
        if (strcasecmp(ending, others[k].ending) == 0)
            return others[k].form;
    return SP_EXPORT_NONE;
}

sp_export_form sp_export_form_named(const char *name) {
    for (int k = 0; k < FORMS; k++)
        if (strcmp(name, forms[k].name) == 0)
            return (sp_export_form)k;
    return SP_EXPORT_NONE;
}

int sp_export_files(sp_export_form form, const char *path, char name[SP_EXPORT_FILES_MAX][SP_EXPORT_PATH_MAX]) {
    int count = 1;
    if (form < 0 || (int)form >= FORMS || strlen(path) >= SP_EXPORT_PATH_MAX)
        return 0;
    memcpy(name[0], path, strlen(path) + 1);
    for (const char *const *beside = forms[form].beside; count < SP_EXPORT_FILES_MAX && *beside; beside++, count++)
        if (!sp_export_beside(path, *beside, name[count]))
            return 0;
    return count;
}

/* ---- writing ---------------------------------------------------------------------------------------------------- */

/* Writes all files. If one fails, those that were not there before are removed. */
static sp_status write_files(int files, char name[][SP_EXPORT_PATH_MAX], const sp_text *text, sp_error *err) {
    bool new[SP_EXPORT_FILES_MAX];
    sp_status status = SP_OK;
    int done = 0;
    for (; done < files && status == SP_OK; done++) {
        new[done] = access(name[done], F_OK) != 0;
        status = sp_file_write(name[done], text[done].data, text[done].size, err);
    }
    for (int k = 0; k < done && status != SP_OK; k++)
        if (new[k])
            unlink(name[k]);
    return status;
}

static sp_status check_vectors(const sp_packing *p, const sp_grain_vectors *v, sp_error *err) {
    for (int32_t k = 0; k < 3 * p->n; k++)
        if (!isfinite(v->displacement[k]) || (v->rotation && !isfinite(v->rotation[k])))
            return sp_fail(err, SP_EINVAL, "the displacement of grain %d is not a finite number", k / 3);
    return SP_OK;
}

static sp_status make_texts(const sp_export_data *e, sp_export_form form, sp_text *text, sp_error *err) {
    sp_locale locale = sp_locale_enter();
    sp_status status = forms[form].write(e, text, err);
    sp_locale_leave(&locale);
    size_t size = 0;
    bool failed = false;
    for (int k = 0; k < SP_EXPORT_FILES_MAX; k++) {
        size += text[k].capacity;
        failed = failed || text[k].failed;
    }
    return status == SP_OK && failed ? sp_fail_memory(err, 2 * size) : status;
}

/* Derived numbers in the units of the file. The threshold of forces needs the packing's own units. */
static sp_status derive(const sp_packing *p, const sp_export_units *u, sp_derived *d, sp_error *err) {
    const sp_status status = sp_derive(p, d, err);
    for (size_t i = 0; i < (size_t)p->n && status == SP_OK; i++) {
        d->mass[i] *= u->mass;
        d->pressure[i] *= u->stress;
        for (int a = 0; a < 3; a++)
            d->net[3 * i + (size_t)a] *= u->force;
        for (int a = 0; a < 9; a++)
            d->stress[9 * i + (size_t)a] *= u->stress;
    }
    return status;
}

/* Writes a packing that has been checked. */
static sp_status write_packing(const sp_packing *p, sp_export_form form, const sp_export_options *o, const char *path,
                               int files, char name[][SP_EXPORT_PATH_MAX], sp_error *err) {
    const sp_export_units units = sp_export_units_of(o->si);
    sp_text text[SP_EXPORT_FILES_MAX] = {{0}};
    sp_packing other = sp_packing_none();
    sp_derived derived = {0};
    const sp_export_data e = {
        .packing = o->si ? &other : p, .derived = &derived, .units = &units, .vectors = o->vectors, .path = path};
    sp_status status = derive(p, &units, &derived, err);
    if (status == SP_OK && o->si)
        status = sp_export_convert(p, &units, &other, err);
    if (status == SP_OK)
        status = make_texts(&e, form, text, err);
    if (status == SP_OK)
        status = write_files(files, name, text, err);
    for (int k = 0; k < SP_EXPORT_FILES_MAX; k++)
        sp_text_free(&text[k]);
    sp_derived_free(&derived);
    sp_packing_free(&other);
    return status;
}

static sp_status check_input(const sp_packing *p, sp_export_form form, const sp_export_options *o, const char *path,
                             sp_error *err) {
    sp_status status = sp_packing_check(p, err);
    if (status == SP_OK && o->vectors && !forms[form].vectors)
        status = sp_fail(err, SP_EINVAL, "%s: this form has no place for displacements", path);
    if (status == SP_OK && o->vectors)
        status = check_vectors(p, o->vectors, err);
    return status == SP_OK && o->si ? sp_material_check(o->si, err) : status;
}

sp_status sp_export(const sp_packing *p, sp_export_form form, const sp_export_options *options, const char *path,
                    sp_error *err) {
    const sp_export_options none = {0}, *o = options ? options : &none;
    char(*name)[SP_EXPORT_PATH_MAX] = sp_alloc(SP_EXPORT_FILES_MAX, sizeof *name);
    if (!name)
        return sp_fail_memory(err, SP_EXPORT_FILES_MAX * sizeof *name);
    const int files = sp_export_files(form, path, name);
    sp_status status = files > 0
                           ? check_input(p, form, o, path, err)
                           : sp_fail(err, SP_EINVAL, "%.100s: not a form of export, or the name is too long", path);
    if (status == SP_OK)
        status = write_packing(p, form, o, path, files, name, err);
    sp_free(name);
    return status;
}
