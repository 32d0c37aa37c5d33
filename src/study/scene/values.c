/* Reads single values and lists from the settings of libconfig, and the list of diameters from a file of its own. */
#include "base/base.h"
#include "base/text.h"
#include "scene/reader.h"
#include "scene/source.h"

#include <math.h>
#include <sonopack/units.h>
#include <stdio.h>
#include <string.h>

/* A value as the file has it, shortened for messages. */
static const char *setting_text(const config_setting_t *setting, char *buf, size_t size) {
    switch (config_setting_type(setting)) {
    case CONFIG_TYPE_INT:
    case CONFIG_TYPE_INT64: snprintf(buf, size, "%lld", config_setting_get_int64(setting)); break;
    case CONFIG_TYPE_FLOAT: sp_number_text(config_setting_get_float(setting), buf); break;
    case CONFIG_TYPE_BOOL: snprintf(buf, size, "%s", config_setting_get_bool(setting) ? "true" : "false"); break;
    case CONFIG_TYPE_STRING: snprintf(buf, size, "\"%.40s\"", config_setting_get_string(setting)); break;
    case CONFIG_TYPE_GROUP: snprintf(buf, size, "{ ... }"); break;
    default: snprintf(buf, size, "a list"); break;
    }
    return buf;
}

sp_status sp_reader_wrong(const sp_reader *r, const sp_field *f, const config_setting_t *setting) {
    char value[64], right[200];
    return sp_fail_key(r->err, SP_EINVAL, f->key, " = %s: must be %s", setting_text(setting, value, sizeof value),
                       sp_field_right(f, right, sizeof right));
}

bool sp_reader_number(const config_setting_t *setting, sp_number *out) {
    const int type = config_setting_type(setting);
    if (type == CONFIG_TYPE_FLOAT) {
        *out = (sp_number){.real = config_setting_get_float(setting)};
        return true;
    }
    if (type != CONFIG_TYPE_INT && type != CONFIG_TYPE_INT64)
        return false;
    *out = (sp_number){.integral = true, .integer = config_setting_get_int64(setting)};
    out->real = (double)out->integer;
    return true;
}

sp_status sp_reader_quantity(const sp_reader *r, const sp_field *f, const config_setting_t *setting, sp_number *out) {
    if (sp_reader_number(setting, out))
        return SP_OK;
    const sp_key *limits = sp_field_limits(f);
    const bool text = config_setting_type(setting) == CONFIG_TYPE_STRING;
    if (!text || !limits || !limits->unit[0] || !strpbrk(config_setting_get_string(setting), "0123456789"))
        return sp_reader_wrong(r, f, setting);
    *out = (sp_number){0};
    sp_status status =
        sp_quantity_read(config_setting_get_string(setting), limits->unit, &r->scene.material, &out->real, r->err);
    return status == SP_OK ? status : sp_fail_prefix_key(r->err, f->key);
}

sp_status sp_reader_checked_number(sp_reader *r, const sp_field *f, const config_setting_t *setting, sp_number *out) {
    r->line = config_setting_source_line(setting);
    sp_status status = sp_reader_quantity(r, f, setting, out);
    return status == SP_OK ? sp_field_check(f, out, r->err) : status;
}

sp_status sp_reader_swept_number(sp_reader *r, const sp_field *f, const config_setting_t *setting, double *out) {
    const double most = 0x1p53; /* sweeps hold doubles, which do not hold every larger integer */
    sp_number number;
    sp_status status = sp_reader_checked_number(r, f, setting, &number);
    if (status != SP_OK)
        return status;
    if (f->type == SP_FIELD_INT64 && (number.integral ? number.integer > (int64_t)most : number.real > most))
        return sp_fail_key(r->err, SP_EINVAL, f->key, " = %.17g: must be %.0f at the most where it is swept",
                           number.real, most);
    *out = number.real + 0.0;
    return SP_OK;
}

const sp_word *sp_reader_word(const sp_field *f, const config_setting_t *setting) {
    if (config_setting_type(setting) != CONFIG_TYPE_STRING)
        return NULL;
    for (const sp_word *w = f->words; w->word; w++)
        if (strcmp(w->word, config_setting_get_string(setting)) == 0)
            return w;
    return NULL;
}

/* ---- lists ------------------------------------------------------------------------------------------------------ */

static sp_status too_many(const sp_reader *r, const sp_field *f, int64_t count) {
    return sp_fail_key(r->err, SP_EINVAL, f->key, ": %lld numbers: must be %d at the most", (long long)count,
                       sp_field_list_max(f));
}

sp_status sp_reader_length(const sp_reader *r, const sp_field *f, const config_setting_t *list) {
    const int count = config_setting_length(list);
    return count > sp_field_list_max(f) ? too_many(r, f, count) : SP_OK;
}

sp_status sp_reader_list(sp_reader *r, const sp_field *f, const config_setting_t *list, double *out) {
    sp_status status = SP_OK;
    for (int k = 0; k < config_setting_length(list) && status == SP_OK; k++) {
        sp_number number;
        status = sp_reader_checked_number(r, f, config_setting_get_elem(list, (unsigned)k), &number);
        if (status == SP_OK)
            out[k] = number.real;
    }
    return status;
}

/* Stores the values in the scene, which owns them from now on. Frees them on failure. */
static sp_status store(sp_reader *r, const sp_field *f, double *values, int count) {
    if (!sp_field_is_planes(f)) {
        sp_scene_own_list(&r->scene, f, values, count);
        return SP_OK;
    }
    sp_status status = SP_OK;
    for (int k = 1; k < count && status == SP_OK; k++)
        if (!(values[k] > values[k - 1]))
            status = sp_fail_key(r->err, SP_EINVAL, f->key, ": %g after %g: must be in ascending order", values[k],
                                 values[k - 1]);
    if (status == SP_OK) {
        r->scene.planes = count;
        if (count > 0)
            memcpy(r->scene.plane, values, (size_t)count * sizeof *values);
    }
    sp_free(values);
    return status;
}

/* The numbers of a list; or one number, where a key of the tapped column has no list. */
static sp_status read_numbers(sp_reader *r, const sp_field *f, const config_setting_t *setting) {
    const bool list = config_setting_is_list(setting);
    const int count = list ? config_setting_length(setting) : 1;
    double *values = count > 0 ? sp_alloc((size_t)count, sizeof *values) : NULL;
    if (count > 0 && !values)
        return sp_fail_memory(r->err, (size_t)count * sizeof *values);
    sp_number one = {0};
    sp_status status = list ? sp_reader_list(r, f, setting, values) : sp_reader_checked_number(r, f, setting, &one);
    if (status != SP_OK) {
        sp_free(values);
        return status;
    }
    if (!list)
        values[0] = one.real;
    return store(r, f, values, count);
}

static sp_status list_of_lists(const sp_reader *r, const sp_field *f) {
    const char *reason = sp_field_not_swept(f);
    if (reason)
        return sp_fail_key(r->err, SP_EINVAL, f->key, " cannot be swept: %s: must be one list", reason);
    return sp_fail_key(r->err, SP_EINVAL, f->key,
                       ": a list of lists: must be one list here; to sweep it, write study.sweep = ( { key = \"%s\"; "
                       "values = ( [...], [...] ); } )",
                       f->key);
}

sp_status sp_read_reals(sp_reader *r, const sp_field *f, const config_setting_t *setting) {
    sp_number number;
    if (!config_setting_is_list(setting) && !(sp_field_is_tapped(f) && sp_reader_number(setting, &number)))
        return sp_reader_wrong(r, f, setting);
    if (config_setting_is_list(setting)) {
        sp_status status = sp_reader_length(r, f, setting);
        if (status != SP_OK)
            return status;
        if (config_setting_length(setting) > 0 && config_setting_is_list(config_setting_get_elem(setting, 0)))
            return list_of_lists(r, f);
    }
    if (r->overrides && strcmp(f->key, "packing.diameters") == 0)
        r->list[0] = '\0';
    return read_numbers(r, f, setting);
}

/* The name of a file. A name in a scene is relative to the scene, a name in --set to the current folder. */
static sp_status read_name(sp_reader *r, const sp_field *f, const config_setting_t *setting, size_t size, char *out) {
    if (config_setting_type(setting) != CONFIG_TYPE_STRING)
        return sp_reader_wrong(r, f, setting);
    const char *name = config_setting_get_string(setting), *slash = r->name ? strrchr(r->name, '/') : NULL;
    const bool beside = !r->overrides && name[0] != '/' && name[0] != '\0' && slash;
    const int length = snprintf(out, size, "%.*s%s", beside ? (int)(slash - r->name) + 1 : 0, r->name, name);
    if (length < 0 || (size_t)length >= size)
        return sp_fail_key(r->err, SP_EINVAL, f->key, " = \"%.60s...\": must be a shorter name", name);
    return SP_OK;
}

sp_status sp_read_list_name(sp_reader *r, const sp_field *f, const config_setting_t *setting) {
    sp_status status = read_name(r, f, setting, sizeof r->list, r->list);
    if (status == SP_OK && r->overrides && r->list[0])
        sp_scene_own_list(&r->scene, sp_field_find("packing.diameters"), NULL, 0);
    return status;
}

sp_status sp_read_path(sp_reader *r, const sp_field *f, const config_setting_t *setting) {
    return read_name(r, f, setting, sizeof r->scene.from, r->scene.from);
}

/* Reads the numbers of a text, one a line. *out grows, and is the caller's even after a failure. */
static sp_status read_lines(sp_reader *r, const sp_field *f, char *text, double **out, int32_t *count) {
    const sp_key *range = sp_field_limits(f);
    sp_lines lines = sp_lines_of(r->list, text, strlen(text));
    size_t capacity = 0;
    for (*count = 0;; ++*count) {
        char *line, *word[1], allowed[128], shown[41];
        double value = NAN;
        sp_status status = sp_lines_next_data(&lines, &line, r->err);
        if (status != SP_OK || !line)
            return status == SP_EFORMAT ? SP_EINVAL : status;
        line[strcspn(line, "#")] = '\0';
        snprintf(shown, sizeof shown, "%s", line);
        if (*count == SP_DIAMETERS_MAX)
            return too_many(r, f, (int64_t)*count + 1);
        if (sp_line_words(line, word, 1) != 1 || !sp_word_number(word[0], &value) || !sp_key_allows(range, value))
            return sp_fail(r->err, SP_EINVAL, "%s:%lld: \"%s\": must be one number %s, # begins a comment", r->list,
                           (long long)lines.number, shown, sp_key_range(range, allowed, sizeof allowed));
        double *grown = sp_grow(*out, (size_t)*count + 1, &capacity, sizeof *grown);
        if (!grown)
            return sp_fail_memory(r->err, (size_t)*count * sizeof *grown);
        *out = grown;
        grown[*count] = value;
    }
}

sp_status sp_reader_load_list(sp_reader *r) {
    const char *key = "packing.diameter_file";
    const sp_field *f = sp_field_find("packing.diameters");
    if (r->scene.pack.diameter_count > 0)
        return sp_fail_key(r->err, SP_EINVAL, key, " = \"%.60s\": must not be given beside packing.diameters", r->list);
    char *text = NULL;
    double *diameters = NULL;
    int32_t count = 0;
    sp_status status = sp_source_load(r->list, "list of diameters", &text, r->err);
    sp_locale locale = sp_locale_enter();
    if (status == SP_OK)
        status = read_lines(r, f, text, &diameters, &count);
    sp_locale_leave(&locale);
    if (status == SP_OK && count == 0)
        status =
            sp_fail(r->err, SP_EINVAL, "%s: an empty list: must hold a diameter for each grain, one a line", r->list);
    sp_free(text);
    if (status == SP_OK)
        sp_scene_own_list(&r->scene, f, diameters, count);
    else
        sp_free(diameters);
    return status == SP_EINVAL ? sp_fail_prefix_key(r->err, key) : status;
}
