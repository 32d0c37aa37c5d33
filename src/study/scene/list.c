/* Lists of numbers in the scene, and of diameters in a file of their own. */
#include "base/base.h"
#include "scene/reader.h"
#include "scene/source.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static sp_status too_many(const sp_reader *r, const sp_field *f, int64_t count) {
    return sp_fail_key(r->err, SP_EINVAL, f->key, ": %lld numbers: must be %d at the most", (long long)count,
                       SP_DIAMETERS_MAX);
}

sp_status sp_reader_length(const sp_reader *r, const sp_field *f, const config_setting_t *list) {
    const int count = config_setting_length(list);
    if (sp_field_is_history(f) && count > SP_HISTORY_MAX)
        return sp_fail_key(r->err, SP_EINVAL, "packing.history", ": %d pressures: must be %d at the most", count,
                           SP_HISTORY_MAX);
    return count > SP_DIAMETERS_MAX ? too_many(r, f, count) : SP_OK;
}

sp_status sp_reader_list(sp_reader *r, const sp_field *f, const config_setting_t *list, double *out) {
    const int count = config_setting_length(list);
    sp_status status = SP_OK;
    for (int k = 0; k < count && status == SP_OK; k++) {
        const config_setting_t *value = config_setting_get_elem(list, (unsigned)k);
        sp_number number;
        r->line = config_setting_source_line(value);
        status = sp_reader_number(value, &number) ? sp_field_check(f, &number, r->err) : sp_reader_wrong(r, f, value);
        if (status == SP_OK)
            out[k] = number.real;
    }
    return status;
}

static sp_status read_planes(sp_reader *r, const sp_field *f, const config_setting_t *setting) {
    const int count = config_setting_length(setting);
    if (count > SP_PLANES_MAX)
        return sp_fail_key(r->err, SP_EINVAL, "signal.planes", ": %d planes: must be %d at the most", count,
                           SP_PLANES_MAX);
    double *plane = r->scene.plane;
    for (int k = 0; k < count; k++) {
        const config_setting_t *value = config_setting_get_elem(setting, (unsigned)k);
        sp_number number;
        r->line = config_setting_source_line(value);
        sp_status status =
            sp_reader_number(value, &number) ? sp_field_check(f, &number, r->err) : sp_reader_wrong(r, f, value);
        if (status != SP_OK)
            return status;
        if (k > 0 && !(number.real > plane[k - 1]))
            return sp_fail_key(r->err, SP_EINVAL, "signal.planes", ": %g after %g: must be in ascending order",
                               number.real, plane[k - 1]);
        plane[k] = number.real;
    }
    r->scene.planes = count;
    return SP_OK;
}

/* The scene owns the values now. */
static void take(sp_scene *s, const sp_field *f, double *values, int32_t count) {
    if (sp_field_is_history(f))
        sp_scene_take_history(s, values, count);
    else if (sp_field_is_masses(f))
        sp_scene_take_masses(s, values, count);
    else if (sp_field_is_radii(f))
        sp_scene_take_radii(s, values, count);
    else
        sp_scene_take_diameters(s, values, count);
}

/* One number of a key that may have several. */
static sp_status read_single(sp_reader *r, const sp_field *f, const sp_number *number) {
    sp_status status = sp_field_check(f, number, r->err);
    double *values = status == SP_OK ? sp_alloc(1, sizeof *values) : NULL;
    if (!values)
        return status == SP_OK ? sp_fail_memory(r->err, sizeof *values) : status;
    values[0] = number->real;
    take(&r->scene, f, values, 1);
    return SP_OK;
}

static sp_status list_of_lists(const sp_reader *r, const sp_field *f) {
    const char *reason = sp_field_not_swept(f);
    if (reason)
        return sp_fail_key(r->err, SP_EINVAL, f->key, " cannot be swept: %s: must be one list", reason);
    return sp_fail_key(r->err, SP_EINVAL, f->key,
                       ": a list of lists: must be one list here, study.sweep sweeps it: ( { key = \"%s\"; "
                       "values = ( [...], [...] ); } )",
                       f->key);
}

sp_status sp_read_reals(sp_reader *r, const sp_field *f, const config_setting_t *setting) {
    sp_number number;
    if (sp_field_is_column(f) && sp_reader_number(setting, &number))
        return read_single(r, f, &number);
    if (!config_setting_is_list(setting))
        return sp_reader_wrong(r, f, setting);
    if (sp_field_is_planes(f))
        return read_planes(r, f, setting);
    sp_status status = sp_reader_length(r, f, setting);
    if (status != SP_OK)
        return status;
    const int count = config_setting_length(setting);
    if (count > 0 && config_setting_is_list(config_setting_get_elem(setting, 0)))
        return list_of_lists(r, f);
    if (r->overrides && strcmp(f->key, "packing.diameters") == 0)
        r->list[0] = '\0';
    double *values = count > 0 ? sp_alloc((size_t)count, sizeof *values) : NULL;
    if (count > 0 && !values)
        return sp_fail_memory(r->err, (size_t)count * sizeof *values);
    status = sp_reader_list(r, f, setting, values);
    if (status != SP_OK)
        sp_free(values);
    else
        take(&r->scene, f, values, count);
    return status;
}

/* The name of a file that a scene gives, which is relative to the scene. */
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
        sp_scene_take_diameters(&r->scene, NULL, 0);
    return status;
}

sp_status sp_read_path(sp_reader *r, const sp_field *f, const config_setting_t *setting) {
    return read_name(r, f, setting, sizeof r->scene.from, r->scene.from);
}

/* A decimal number that fills the line but for blanks and a comment. strtod alone would take "nan", "inf" and
 * hexadecimal numbers, too. */
static bool number_of_line(const char *line, const char *end, double *out) {
    char word[64];
    while (line < end && isspace((unsigned char)*line))
        line++;
    while (end > line && isspace((unsigned char)end[-1]))
        end--;
    const size_t n = (size_t)(end - line);
    if (n == 0 || n >= sizeof word)
        return false;
    memcpy(word, line, n);
    word[n] = '\0';
    char *rest;
    if (word[strspn(word, "0123456789+-.eE")] != '\0')
        return false;
    *out = strtod(word, &rest);
    return *rest == '\0';
}

static bool is_blank(const char *line, const char *end) {
    while (line < end && isspace((unsigned char)*line))
        line++;
    return line == end;
}

/* The numbers of the text; *count of them on success. */
static sp_status read_lines(sp_reader *r, const sp_field *f, const char *text, double *out, int32_t *count) {
    const sp_key *range = sp_field_limits(f);
    char text_of_range[128];
    int32_t used = 0;
    int64_t number = 1;
    if (strncmp(text, "\xef\xbb\xbf", 3) == 0) /* the byte order mark of some editors */
        text += 3;
    for (const char *line = text; *line; number++) {
        const char *next = line + strcspn(line, "\n"), *end = line + strcspn(line, "#\n");
        if (!is_blank(line, end)) {
            double value = NAN;
            if (used == SP_DIAMETERS_MAX)
                return too_many(r, f, (int64_t)used + 1);
            if (!number_of_line(line, end, &value) || !sp_key_allows(range, value))
                return sp_fail(r->err, SP_EINVAL, "%s:%lld: \"%.*s\": must be one number %s, # begins a comment",
                               r->list, (long long)number, (int)(end - line < 40 ? end - line : 40), line,
                               sp_key_range(range, text_of_range, sizeof text_of_range));
            out[used++] = value;
        }
        line = *next ? next + 1 : next;
    }
    if (used == 0)
        return sp_fail(r->err, SP_EINVAL, "%s: an empty list: must hold a diameter for each grain, one a line",
                       r->list);
    *count = used;
    return SP_OK;
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
    if (status != SP_OK)
        goto out;
    size_t lines = 1;
    for (const char *at = text; *at; at++)
        lines += *at == '\n';
    if (lines > SP_DIAMETERS_MAX)
        lines = SP_DIAMETERS_MAX;
    diameters = sp_alloc(lines, sizeof *diameters);
    status = diameters ? read_lines(r, f, text, diameters, &count) : sp_fail_memory(r->err, lines * sizeof *diameters);
    if (status == SP_OK) {
        sp_scene_take_diameters(&r->scene, diameters, count);
        diameters = NULL;
    }
out:
    sp_free(diameters);
    sp_free(text);
    if (status == SP_EINVAL)
        sp_fail_prefix_key(r->err, key);
    return status;
}
