/* Reads a packing from two tables: grains.tsv 'id x y [z] radius' and contacts.tsv 'i j nx ny [nz] overlap Fn Ft'. Box
 * and material are in comment lines '# key = value'. */
#include "base/base.h"
#include "packing/contact.h"
#include "packing/geometry.h"
#include "store/exchange.h"
#include "table/words.h"

#include <math.h>
#include <sonopack/study/store.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const axis[3] = {"x", "y", "z"};
static const char *const edge_key[3] = {"width", "depth", "height"};

/* ---- keys ------------------------------------------------------------------------------------------------------ */

static const char *const known_key[] = {"dimension", "width",    "depth",    "height",  "cell", "xy",       "xz",  "yz",
                                        "gravity",   "pressure", "friction", "poisson", "wall", "material", "seed"};

typedef struct keys {
    const sp_word_table *grains, *contacts;
    int count;
    char *const *given; /* "key=value", which override the comments */
} keys;

/* The value in "key=value" or "packing.key=value", if the key has this name; else NULL. */
static const char *given_value(const char *given, const char *name) {
    if (strncmp(given, "packing.", 8) == 0)
        given += 8;
    size_t length = strlen(name);
    return strncmp(given, name, length) == 0 && given[length] == '=' ? given + length + 1 : NULL;
}

static sp_status check_given(const keys *k, sp_error *err) {
    for (int g = 0; g < k->count; g++) {
        bool known = false;
        for (size_t n = 0; n < sizeof known_key / sizeof *known_key; n++)
            known = known || given_value(k->given[g], known_key[n]);
        if (!known)
            return sp_fail(err, SP_EINVAL,
                           "'%.100s': must be key=value with one of the keys dimension, width, depth (3D), height, "
                           "cell, xy, xz, yz, gravity, pressure, friction, poisson, wall, material, seed",
                           k->given[g]);
    }
    return SP_OK;
}

/* Finds the first word of a key's value; false if it is not given. *where is where it was given, for messages. */
static bool find_value(const keys *k, const char *name, char value[SP_MATERIAL_TEXT], const char **where) {
    const char *text = NULL;
    for (int g = k->count - 1; g >= 0 && !text; g--)
        text = given_value(k->given[g], name);
    *where = text ? "option" : k->grains->file;
    if (!text)
        text = sp_word_table_value(k->grains, name);
    if (!text) {
        text = sp_word_table_value(k->contacts, name);
        *where = k->contacts->file;
    }
    if (text)
        snprintf(value, SP_MATERIAL_TEXT, "%.*s", (int)strcspn(text, " \t"), text);
    return text != NULL;
}

static sp_status fail_value(const char *name, const char *value, const char *where, const char *rule, sp_error *err) {
    return sp_fail(err, strcmp(where, "option") == 0 ? SP_EINVAL : SP_EFORMAT, "%s: %s is '%.60s'; must be %s", where,
                   name, value, rule);
}

/* Reads a numeric key. With fallback = NAN the key is required. */
static sp_status number_key(const keys *k, const char *name, double fallback, double *out, sp_error *err) {
    char value[SP_MATERIAL_TEXT];
    const char *where;
    if (!find_value(k, name, value, &where)) {
        *out = fallback;
        return isnan(fallback)
                   ? sp_fail(err, SP_EFORMAT, "%s: no %s; must be in a comment line '# %s = ...' or `--set %s=...'",
                             k->grains->file, name, name, name)
                   : SP_OK;
    }
    if (!sp_word_number(value, out) || !isfinite(*out))
        return fail_value(name, value, where, "a finite number", err);
    return SP_OK;
}

static sp_status read_dimension(const keys *k, int *dim, sp_error *err) {
    double columns = sp_word_table_find(k->grains, "z") >= 0   ? 3
                     : sp_word_table_find(k->grains, "y") >= 0 ? 2
                                                               : 1,
           value;
    sp_status status = number_key(k, "dimension", columns, &value, err);
    if (status != SP_OK)
        return status;
    if (value != 1 && value != 2 && value != 3)
        return sp_fail(err, SP_EFORMAT, "%s: dimension is %g; must be 1, 2 or 3", k->grains->file, value);
    if (value > columns)
        return sp_fail(err, SP_EFORMAT, "%s: dimension is %g, but there is no column '%s'", k->grains->file, value,
                       axis[(int)columns]);
    *dim = (int)value; /* if there are more columns, the last are ignored */
    return SP_OK;
}

/* The kind of the cell, its tilt and gravity: those of a piston where they are not given. */
static sp_status read_cell(const keys *k, sp_packing *p, sp_error *err) {
    static const char *const tilt[3] = {"xy", "xz", "yz"};
    char value[SP_MATERIAL_TEXT];
    const char *where;
    sp_status status = number_key(k, "gravity", 0.0, &p->gravity, err);
    for (int a = 0; status == SP_OK && a < 3; a++)
        status = number_key(k, tilt[a], 0.0, &p->tilt[a], err);
    if (status == SP_OK && find_value(k, "cell", value, &where) && !sp_cell_read(value, &p->cell))
        status = fail_value("cell", value, where, "piston, periodic or box", err);
    return status;
}

static sp_status read_box_and_material(const keys *k, sp_packing *p, sp_error *err) {
    char value[SP_MATERIAL_TEXT];
    const char *where;
    sp_status status = read_cell(k, p, err);
    for (int a = 0; status == SP_OK && a < p->dim; a++)
        status = number_key(k, edge_key[a == p->dim - 1 ? 2 : a], NAN, &p->box[a], err);
    for (int a = 0; status == SP_OK && a < p->dim; a++)
        if (!(p->box[a] > 0))
            status = sp_fail(err, SP_EFORMAT, "%s: %s is %g; must be positive", k->grains->file,
                             edge_key[a == p->dim - 1 ? 2 : a], p->box[a]);
    if (status == SP_OK)
        status = number_key(k, "pressure", NAN, &p->pressure, err);
    if (status == SP_OK)
        status = number_key(k, "friction", NAN, &p->friction, err);
    if (status == SP_OK)
        status = number_key(k, "poisson", 0.0, &p->poisson, err);
    if (status == SP_OK && find_value(k, "seed", value, &where) && !sp_word_unsigned(value, &p->seed))
        status = fail_value("seed", value, where, "a whole number of 64 bits", err);
    if (status == SP_OK && find_value(k, "wall", value, &where) && !sp_wall_read(value, &p->wall))
        status = fail_value("wall", value, where, "rigid, grain or elastic", err);
    if (status == SP_OK && find_value(k, "material", value, &where)) {
        status = sp_material_read(value, &p->material, err);
        if (status != SP_OK)
            sp_fail_prefix(err, "%s", where);
    }
    return status;
}

/* ---- grains ---------------------------------------------------------------------------------------------------- */

typedef struct grain_id {
    const char *word;
    int32_t index;
} grain_id;

static int compare_ids(const void *a, const void *b) {
    return strcmp(((const grain_id *)a)->word, ((const grain_id *)b)->word);
}

static int compare_ids_then_rows(const void *a, const void *b) {
    const grain_id *p = a, *q = b;
    int order = compare_ids(p, q);
    return order ? order : (p->index > q->index) - (p->index < q->index);
}

static sp_status need_column(const sp_word_table *s, const char *name, int *column, sp_error *err) {
    *column = sp_word_table_find(s, name);
    if (*column < 0)
        return sp_fail(err, SP_EFORMAT, "%s: no column '%s' in the header row", s->file, name);
    return SP_OK;
}

/* Reads a finite number from a cell. */
static sp_status cell_number(const sp_word_table *s, int64_t row, int column, double *out, sp_error *err) {
    const char *word = sp_word_table_cell(s, row, column);
    if (!sp_word_number(word, out) || !isfinite(*out))
        return sp_fail(err, SP_EFORMAT, "%s:%lld: %s is '%.60s'; must be a finite number", s->file,
                       (long long)s->line[row], s->name[column], word);
    return SP_OK;
}

/* The wall of a name. Under a piston left, right, front and back are free for grains. */
static bool is_wall(const sp_packing *p, const char *word, int32_t *wall) {
    return sp_side_read(word, wall) && (*wall >= SP_TOP || sp_packing_has_wall(p, *wall));
}

static sp_status read_ids(const sp_word_table *s, const sp_packing *p, grain_id *id, sp_error *err) {
    int32_t wall;
    int column;
    sp_status status = need_column(s, "id", &column, err);
    if (status != SP_OK)
        return status;
    for (int64_t row = 0; row < s->rows; row++) {
        id[row] = (grain_id){sp_word_table_cell(s, row, column), (int32_t)row};
        if (!*id[row].word || is_wall(p, id[row].word, &wall))
            return sp_fail(err, SP_EFORMAT, "%s:%lld: id is '%s'; must be a number or word, not the name of a wall",
                           s->file, (long long)s->line[row], id[row].word);
    }
    qsort(id, (size_t)s->rows, sizeof *id, compare_ids_then_rows);
    for (int64_t k = 1; k < s->rows; k++)
        if (compare_ids(&id[k - 1], &id[k]) == 0)
            return sp_fail(err, SP_EFORMAT, "%s:%lld: id %.60s stands already in line %lld", s->file,
                           (long long)s->line[id[k].index], id[k].word, (long long)s->line[id[k - 1].index]);
    return SP_OK;
}

/* Reads the masses of grains that are no spheres of unit density. */
static sp_status read_masses(const sp_word_table *s, sp_packing *p, sp_error *err) {
    const int mass = sp_word_table_find(s, "mass"), inertia = sp_word_table_find(s, "inertia");
    if (mass < 0 && inertia < 0)
        return SP_OK;
    if (mass < 0 || inertia < 0)
        return sp_fail(err, SP_EFORMAT, "%s: a column '%s' alone; must be both mass and inertia, or neither", s->file,
                       mass < 0 ? "inertia" : "mass");
    sp_status status = sp_packing_alloc_masses(p, err);
    for (int32_t i = 0; status == SP_OK && i < p->n; i++) {
        status = cell_number(s, i, mass, &p->mass[i], err);
        if (status == SP_OK)
            status = cell_number(s, i, inertia, &p->inertia[i], err);
        if (status == SP_OK && !(p->mass[i] > 0 && p->inertia[i] > 0))
            status = sp_fail(err, SP_EFORMAT, "%s:%lld: mass is %g and inertia %g; must be positive", s->file,
                             (long long)s->line[i], p->mass[i], p->inertia[i]);
    }
    return status;
}

static sp_status read_grains(const sp_word_table *s, sp_packing *p, sp_error *err) {
    int column[4];
    sp_status status = need_column(s, "radius", &column[3], err);
    for (int a = 0; status == SP_OK && a < p->dim; a++)
        status = need_column(s, axis[a], &column[a], err);
    for (int32_t i = 0; status == SP_OK && i < p->n; i++) {
        for (int a = 0; status == SP_OK && a < p->dim; a++)
            status = cell_number(s, i, column[a], &p->x[3 * i + a], err);
        if (status == SP_OK)
            sp_wrap_grain(p, p->x + 3 * i);
        if (status == SP_OK)
            status = cell_number(s, i, column[3], &p->r[i], err);
        if (status == SP_OK && !(p->r[i] > 0))
            status = sp_fail(err, SP_EFORMAT, "%s:%lld: radius is %g; must be positive", s->file, (long long)s->line[i],
                             p->r[i]);
    }
    return status == SP_OK ? read_masses(s, p, err) : status;
}

/* ---- contacts -------------------------------------------------------------------------------------------------- */

typedef struct contact_columns {
    int i, j, n[3], overlap, fn, ft, ft3[3], kn, kt; /* -1: missing */
} contact_columns;

static sp_status find_columns(const sp_word_table *s, int dim, contact_columns *c, sp_error *err) {
    static const char *const normal[3] = {"nx", "ny", "nz"}, *const tangent[3] = {"Ftx", "Fty", "Ftz"};
    sp_status status = need_column(s, "i", &c->i, err);
    if (status == SP_OK)
        status = need_column(s, "j", &c->j, err);
    int vector = 0;
    for (int a = 0; status == SP_OK && a < dim; a++) {
        status = need_column(s, normal[a], &c->n[a], err);
        c->ft3[a] = sp_word_table_find(s, tangent[a]);
        vector += c->ft3[a] >= 0;
    }
    if (status != SP_OK)
        return status;
    c->overlap = sp_word_table_find(s, "overlap");
    c->fn = sp_word_table_find(s, "Fn");
    c->ft = sp_word_table_find(s, "Ft");
    c->kn = sp_word_table_find(s, "kn");
    c->kt = sp_word_table_find(s, "kt");
    if (c->kt >= 0 && c->kn < 0)
        return sp_fail(err, SP_EFORMAT, "%s: a column 'kt' without 'kn'; must be both, or kn alone", s->file);
    if (c->overlap < 0 && c->fn < 0)
        return sp_fail(err, SP_EFORMAT, "%s: neither a column 'overlap' nor 'Fn' in the header row", s->file);
    if (vector != 0 && vector != dim)
        return sp_fail(err, SP_EFORMAT, "%s: %d of the %d columns Ftx, Fty%s", s->file, vector, dim,
                       dim == 3 ? ", Ftz" : "");
    if (c->ft >= 0 && (vector || dim == 3))
        return sp_fail(err, SP_EFORMAT, "%s: a column 'Ft', where the force must be in Ftx, Fty%s", s->file,
                       dim == 3 ? ", Ftz" : " alone");
    return SP_OK;
}

static sp_status find_grain(const sp_word_table *s, int64_t row, int column, const grain_id *id, const sp_packing *p,
                            int32_t *out, sp_error *err) {
    const char *word = sp_word_table_cell(s, row, column);
    if (is_wall(p, word, out))
        return SP_OK;
    const grain_id key = {word, 0}, *found = bsearch(&key, id, (size_t)p->n, sizeof *id, compare_ids);
    if (!found)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: %s is '%.60s'; must be the id of a grain, or a wall: bottom, top%s",
                       s->file, (long long)s->line[row], s->name[column], word,
                       p->cell == SP_CELL_BOX ? ", left, right, front, back" : "");
    *out = found->index;
    return SP_OK;
}

/* Reads an optional number: NAN if the column is missing or the cell empty. */
static sp_status optional_number(const sp_word_table *s, int64_t row, int column, double *out, sp_error *err) {
    *out = NAN;
    if (column < 0 || !*sp_word_table_cell(s, row, column))
        return SP_OK;
    return cell_number(s, row, column, out, err);
}

/* Computes overlap or normal force from the other, if only one is given: by Hertz's law (A1 of docs/physics.md), or as
 * a linear spring where the stiffness is given. Without kt it is Mindlin's part of kn. */
static sp_status complete(const sp_packing *p, sp_contact_row *row, sp_error *err) {
    if (isnan(row->overlap) && isnan(row->fn))
        return sp_fail(err, SP_EFORMAT, "neither overlap nor Fn");
    if (row->overlap < 0 || row->fn < 0)
        return sp_fail(err, SP_EFORMAT, "overlap %g, Fn %g; must be >= 0", row->overlap, row->fn);
    int32_t grain = row->i >= 0 ? row->i : row->j;
    if (grain < 0)
        return SP_OK; /* two walls: sp_contact_from_row refuses them */
    const double e = contact_stiffness_in(p, grain, row->i < 0 || row->j < 0 ? SP_BOTTOM : row->j);
    const bool spring = row->kn > 0;
    if (isnan(row->overlap))
        row->overlap = spring ? row->fn / row->kn : contact_overlap(e, row->fn);
    else if (isnan(row->fn))
        row->fn = spring ? row->kn * row->overlap : contact_force(e, row->overlap);
    if (isnan(row->kt))
        row->kt = spring ? contact_eta(p->poisson) * row->kn : 0;
    return SP_OK;
}

static sp_status read_row(const sp_word_table *s, int64_t row, const contact_columns *column, sp_contact_row *out,
                          int dim, sp_error *err) {
    sp_status status = SP_OK;
    out->vector = column->ft3[0] >= 0;
    for (int a = 0; status == SP_OK && a < dim; a++) {
        status = cell_number(s, row, column->n[a], &out->n[a], err);
        if (status == SP_OK && out->vector)
            status = cell_number(s, row, column->ft3[a], &out->ft3[a], err);
    }
    if (status == SP_OK && column->ft >= 0)
        status = cell_number(s, row, column->ft, &out->ft, err);
    if (status == SP_OK)
        status = optional_number(s, row, column->overlap, &out->overlap, err);
    if (status == SP_OK)
        status = optional_number(s, row, column->fn, &out->fn, err);
    if (status == SP_OK)
        status = optional_number(s, row, column->kn, &out->kn, err);
    if (status == SP_OK)
        status = optional_number(s, row, column->kt, &out->kt, err);
    if (isnan(out->kn)) /* an empty cell */
        out->kn = 0;
    return status;
}

static sp_status read_contacts(const sp_word_table *s, const grain_id *id, sp_packing *p, sp_error *err) {
    contact_columns column;
    sp_status status = find_columns(s, p->dim, &column, err);
    for (int32_t c = 0; status == SP_OK && c < p->n_contacts; c++) {
        /* measured normals have few digits, and are normalised */
        sp_contact_row row = {.unit_within = 1e-3};
        status = find_grain(s, c, column.i, id, p, &row.i, err);
        if (status == SP_OK)
            status = find_grain(s, c, column.j, id, p, &row.j, err);
        if (status == SP_OK)
            status = read_row(s, c, &column, &row, p->dim, err);
        if (status != SP_OK)
            break;
        status = complete(p, &row, err);
        if (status == SP_OK)
            status = sp_contact_from_row(p, &row, &p->contacts[c], err);
        if (status != SP_OK)
            sp_fail_prefix(err, "%s:%lld", s->file, (long long)s->line[c]);
    }
    return status;
}

static sp_status check_sizes(const sp_word_table *grains, const sp_word_table *contacts, sp_error *err) {
    if (grains->rows < 1 || grains->rows > INT32_MAX / 4)
        return sp_fail(err, SP_EFORMAT, "%s: %lld grains; must be 1..%d", grains->file, (long long)grains->rows,
                       INT32_MAX / 4);
    if (contacts->rows > INT32_MAX / 4)
        return sp_fail(err, SP_EFORMAT, "%s: %lld contacts; at most %d", contacts->file, (long long)contacts->rows,
                       INT32_MAX / 4);
    return SP_OK;
}

static sp_status read_sheets(const keys *k, grain_id *id, sp_packing *p, sp_error *err) {
    sp_status status = read_box_and_material(k, p, err);
    if (status == SP_OK)
        status = read_ids(k->grains, p, id, err);
    if (status == SP_OK)
        status = read_grains(k->grains, p, err);
    if (status == SP_OK)
        status = read_contacts(k->contacts, id, p, err);
    if (status != SP_OK)
        return status;
    sp_packing_sort(p);
    status = sp_packing_check(p, err);
    if (status != SP_OK)
        sp_fail_prefix(err, "%s, %s", k->grains->file, k->contacts->file);
    return status;
}

sp_status sp_packing_read_tables(const char *grains, const char *contacts, int count, char *const *given,
                                 sp_packing *out, sp_error *err) {
    sp_word_table g = {0}, c = {0};
    const keys k = {&g, &c, count, given};
    sp_packing p = sp_packing_none();
    grain_id *id = NULL;
    int dim = 0;
    sp_locale locale = sp_locale_enter();
    sp_status status = check_given(&k, err);
    if (status == SP_OK)
        status = sp_word_table_read(grains, &g, err);
    if (status == SP_OK)
        status = sp_word_table_read(contacts, &c, err);
    if (status == SP_OK)
        status = check_sizes(&g, &c, err);
    if (status == SP_OK)
        status = read_dimension(&k, &dim, err);
    if (status == SP_OK && !(id = sp_alloc((size_t)g.rows, sizeof *id)))
        status = sp_fail_memory(err, (size_t)g.rows * sizeof *id);
    if (status == SP_OK)
        status = sp_packing_alloc(&p, dim, (int32_t)g.rows, (int32_t)c.rows, err);
    if (status == SP_OK)
        status = read_sheets(&k, id, &p, err);
    sp_locale_leave(&locale);
    sp_free(id);
    sp_word_table_free(&g);
    sp_word_table_free(&c);
    if (status == SP_OK)
        *out = p;
    else
        sp_packing_free(&p);
    return status;
}
