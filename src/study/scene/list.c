/* Reads lists of numbers from a scene, and the list of diameters from a file of its own. */
#include "base/base.h"
#include "base/text.h"
#include "scene/reader.h"
#include "scene/source.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

/* Reads a line that holds one decimal number, with blanks around it. strtod alone would also accept "nan", "inf" and
 * hexadecimal numbers. */
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
    sp_locale locale = sp_locale_enter();
    *out = strtod(word, &rest);
    sp_locale_leave(&locale);
    return *rest == '\0';
}

static bool is_blank(const char *line, const char *end) {
    while (line < end && isspace((unsigned char)*line))
        line++;
    return line == end;
}

/* Reads the numbers of a text, one a line; *count says how many on success. */
static sp_status read_lines(sp_reader *r, const sp_field *f, const char *text, double *out, int32_t *count) {
    const sp_key *range = sp_field_limits(f);
    char allowed[128];
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
                               sp_key_range(range, allowed, sizeof allowed));
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
        sp_scene_own_list(&r->scene, f, diameters, count);
        diameters = NULL;
    }
out:
    sp_free(diameters);
    sp_free(text);
    if (status == SP_EINVAL)
        sp_fail_prefix_key(r->err, key);
    return status;
}
