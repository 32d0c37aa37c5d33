/* Which column of a file means what. */
#include "base/base.h"
#include "foreign/work.h"
#include "store/exchange.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

char *sp_work_pressure(const sp_work *w, double pressure, char text[SP_WORK_TEXT]) {
    const sp_material *m = &w->report.material;
    if (m->young > 0)
        snprintf(text, SP_WORK_TEXT, "%.6g E* (%.6g kPa)", pressure, 1e-3 * pressure * sp_material_modulus(m));
    else
        snprintf(text, SP_WORK_TEXT, "%.6g", pressure);
    return text;
}

char *sp_work_length(const sp_work *w, double length, char text[SP_WORK_TEXT]) {
    const sp_material *m = &w->report.material;
    if (m->young > 0)
        snprintf(text, SP_WORK_TEXT, "%.6g d (%.6g mm)", length, 1e3 * length * m->diameter);
    else
        snprintf(text, SP_WORK_TEXT, "%.6g", length);
    return text;
}

void sp_work_note(sp_work *w, const char *format, ...) {
    if (w->report.notes == SP_IMPORT_NOTES)
        return;
    va_list list;
    va_start(list, format);
    vsnprintf(w->report.note[w->report.notes++], SP_IMPORT_NOTE, format, list);
    va_end(list);
}

/* The roles, and the names that programs give to their columns. sp_id, sp_contact and sp_gran are the computes of
 * share/sonopack. */
static const struct usual {
    const char *role, *names; /* separated by blanks */
} usual[] = {
    {"id", "id ID Id c_sp_wall[3]"},
    {"type", "type matId species info mol element"},
    {"x", "x xu xs xsu X"},
    {"y", "y yu ys ysu Y"},
    {"z", "z zu zs zsu Z"},
    {"radius", "radius r R rad Radius"},
    {"diameter", "diameter d D"},
    {"mass", "mass m masses"},
    {"inertia", "inertia"},
    {"density", "density"},
    {"boundary", "boundary"},
    {"bottom", ""},
    {"top", ""},
    {"left", ""},
    {"right", ""},
    {"front", ""},
    {"back", ""},
    {"id1", "id1 i patom1 c_sp_id[1] c_sp_gran[1]"},
    {"id2", "id2 j patom2 c_sp_id[2] c_sp_gran[2]"},
    {"overlap", "overlap penetrationDepth c_sp_gran[13]"},
    {"fn", "fn Fn force c_sp_contact[2]"},
    {"ft", "ft Ft"},
    {"ft_x", "ft_x Ftx p1 c_sp_contact[3] c_sp_gran[10]"},
    {"ft_y", "ft_y Fty p2 c_sp_contact[4] c_sp_gran[11]"},
    {"ft_z", "ft_z Ftz p3 c_sp_contact[5] c_sp_gran[12]"},
    {"t_x", "t_x"},
    {"t_y", "t_y"},
    {"t_z", "t_z"},
    {"fn_x", "fn_x c_sp_gran[7]"},
    {"fn_y", "fn_y c_sp_gran[8]"},
    {"fn_z", "fn_z c_sp_gran[9]"},
    {"f_x", "f_x c_sp_wall[4]"},
    {"f_y", "f_y c_sp_wall[5]"},
    {"f_z", "f_z c_sp_wall[6]"},
    {"p_x", "p_x"},
    {"p_y", "p_y"},
    {"p_z", "p_z"},
    {"kn", "kn"},
    {"kt", "kt ks"},
};

static int find_role(const char *role) {
    for (int k = 0; k < (int)(sizeof usual / sizeof *usual); k++)
        if (strcmp(usual[k].role, role) == 0)
            return k;
    return -1;
}

static sp_status fail_role(const char *role, sp_error *err) {
    char list[500] = "";
    size_t used = 0;
    for (size_t k = 0; k < sizeof usual / sizeof *usual && used < sizeof list; k++)
        used += (size_t)snprintf(list + used, sizeof list - used, " %s", usual[k].role);
    return sp_fail(err, SP_EINVAL, "--columns %.40s: must be ROLE=COLUMN, separated by commas, with a role of:%s", role,
                   list);
}

/* One "role=column" or "role=-column". */
static sp_status read_role(sp_work *w, const char *text, size_t length, sp_error *err) {
    char word[200];
    snprintf(word, sizeof word, "%.*s", (int)length, text);
    char *equal = strchr(word, '=');
    if (!equal)
        return fail_role(word, err);
    *equal = '\0';
    const char *column = equal + 1;
    if (find_role(word) < 0 || !*column || length >= sizeof word)
        return fail_role(word, err);
    if (w->roles == SP_ROLES_MAX)
        return sp_fail(err, SP_EINVAL, "--columns: more than %d roles", SP_ROLES_MAX);
    sp_role *r = &w->role[w->roles++];
    r->sign = *column == '-' ? -1 : 1;
    column += *column == '-';
    snprintf(r->role, sizeof r->role, "%.23s", word);
    snprintf(r->column, sizeof r->column, "%.63s", column);
    return SP_OK;
}

sp_status sp_roles_read(sp_work *w, sp_error *err) {
    const char *text = w->o->columns;
    sp_status status = SP_OK;
    while (status == SP_OK && text && *text) {
        const size_t length = strcspn(text, ",");
        status = read_role(w, text, length, err);
        text += length;
        text += *text == ',';
    }
    return status;
}

sp_place sp_role_find(sp_work *w, const sp_number_sheet *s, const char *role) {
    for (int k = 0; k < w->roles; k++) {
        if (strcmp(w->role[k].role, role) != 0)
            continue;
        const int index = sp_sheet_find(s, w->role[k].column);
        w->used[k] = w->used[k] || index >= 0;
        if (index >= 0)
            return (sp_place){index, w->role[k].sign};
    }
    char names[200];
    snprintf(names, sizeof names, "%s", usual[find_role(role)].names);
    char *rest = names;
    for (char *name; (name = strsep(&rest, " "));) {
        const int index = *name ? sp_sheet_find(s, name) : -1;
        if (index >= 0)
            return (sp_place){index, 1};
    }
    return (sp_place){-1, 1};
}

bool sp_role_is_named(const sp_work *w, const char *role) {
    for (int k = 0; k < w->roles; k++)
        if (strcmp(w->role[k].role, role) == 0)
            return true;
    return false;
}

double sp_axis_sign(const sp_work *w, int axis) {
    const char name[2] = {"xyz"[axis], '\0'};
    for (int k = 0; k < w->roles; k++)
        if (strcmp(w->role[k].role, name) == 0)
            return w->role[k].sign;
    return 1;
}

sp_status sp_role_need(sp_work *w, const sp_number_sheet *s, const char *role, sp_place *out, sp_error *err) {
    *out = sp_role_find(w, s, role);
    if (out->index >= 0)
        return SP_OK;
    char names[500];
    return sp_fail(err, SP_EFORMAT, "%s: no column for %s; its columns are: %s-- name it by --columns %s=COLUMN",
                   s->file, role, sp_sheet_names(s, names, sizeof names), role);
}

sp_status sp_place_number(const sp_number_sheet *s, int64_t row, sp_place at, double *out, sp_error *err) {
    *out = NAN;
    if (at.index < 0)
        return SP_OK;
    sp_status status = sp_sheet_number(s, row, at.index, out, err);
    *out *= at.sign;
    return status;
}

sp_status sp_role_vector(sp_work *w, const sp_number_sheet *s, const char *role, sp_place out[3], bool *given,
                         sp_error *err) {
    int count = 0;
    for (int a = 0; a < 3; a++)
        out[a] = (sp_place){-1, 1};
    for (int a = 0; a < w->dim; a++) {
        char name[24];
        snprintf(name, sizeof name, "%.20s_%c", role, "xyz"[w->axis[a]]);
        out[a] = sp_role_find(w, s, name);
        if (!sp_role_is_named(w, name))
            out[a].sign *= sp_axis_sign(w, w->axis[a]);
        count += out[a].index >= 0;
    }
    for (int a = 0; a < 3; a++) { /* those of axes that the packing does not have are named all the same */
        char name[24];
        snprintf(name, sizeof name, "%.20s_%c", role, "xyz"[a]);
        sp_role_find(w, s, name);
    }
    *given = count == w->dim;
    if (count > 0 && !*given)
        return sp_fail(err, SP_EFORMAT, "%s: %d of %d columns of %s_x, %s_y%s; must be all or none", s->file, count,
                       w->dim, role, role, w->dim == 3 ? ", ..." : "");
    return SP_OK;
}

sp_status sp_place_vector(const sp_number_sheet *s, int64_t row, const sp_place *at, double *out, sp_error *err) {
    sp_status status = SP_OK;
    for (int a = 0; a < 3 && status == SP_OK; a++) {
        out[a] = 0; /* axes that the packing does not have */
        if (at[a].index >= 0)
            status = sp_place_number(s, row, at[a], &out[a], err);
    }
    return status;
}

sp_status sp_roles_check(const sp_work *w, sp_error *err) {
    for (int k = 0; k < w->roles; k++) {
        int32_t wall;
        const bool prefix = sp_side_read(w->role[k].role, &wall);
        if (w->used[k] || prefix)
            continue;
        char names[500];
        const sp_number_sheet *s =
            w->contacts.file && find_role(w->role[k].role) >= find_role("id1") ? &w->contacts : &w->grains;
        return sp_fail(err, SP_EINVAL, "--columns %s=%s: %s has no such column; its columns are: %s", w->role[k].role,
                       w->role[k].column, s->file, sp_sheet_names(s, names, sizeof names));
    }
    return SP_OK;
}
