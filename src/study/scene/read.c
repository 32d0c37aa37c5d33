/* Turns the text of a scene into a checked sp_scene. */
#include "base/base.h"
#include "base/text.h"
#include "scene/reader.h"
#include "scene/source.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

static sp_status read_list(sp_reader *r, const sp_field *f, const config_setting_t *setting) {
    const bool list = config_setting_is_list(setting);
    const int count = list ? config_setting_length(setting) : 1;
    unsigned bits = 0;
    for (int k = 0; k < count; k++) {
        const config_setting_t *one = list ? config_setting_get_elem(setting, (unsigned)k) : setting;
        r->line = config_setting_source_line(one);
        const sp_word *word = sp_reader_word(f, one);
        if (!word)
            return sp_reader_wrong(r, f, one);
        bits |= word->value;
    }
    memcpy((char *)&r->scene + f->offset, &bits, sizeof bits);
    return SP_OK;
}

static sp_status read_field(sp_reader *r, const sp_field *f, const config_setting_t *setting) {
    sp_status status;
    sp_number number;
    const sp_word *word;
    char *place = (char *)&r->scene + f->offset;
    if (sp_field_is_scalar(f)) {
        if (config_setting_is_list(setting) || config_setting_is_group(setting))
            return sp_read_direct(r, f, setting);
        sp_drop_direct(r, f);
    }
    switch (f->type) {
    case SP_FIELD_REAL:
    case SP_FIELD_INT:
    case SP_FIELD_INT64:
        status = sp_reader_quantity(r, f, setting, &number);
        return status == SP_OK ? sp_field_store(&r->scene, f, &number, r->err) : status;
    case SP_FIELD_BOOL:
        if (config_setting_type(setting) != CONFIG_TYPE_BOOL)
            return sp_reader_wrong(r, f, setting);
        *(bool *)place = config_setting_get_bool(setting);
        return SP_OK;
    case SP_FIELD_WORD:
        word = sp_reader_word(f, setting);
        if (!word)
            return sp_reader_wrong(r, f, setting);
        memcpy(place, &word->value, sizeof word->value);
        return SP_OK;
    case SP_FIELD_LIST: return read_list(r, f, setting);
    case SP_FIELD_SWEEP: return sp_read_sweeps(r, f, setting);
    case SP_FIELD_REALS: return sp_read_reals(r, f, setting);
    case SP_FIELD_PATH: return sp_read_path(r, f, setting);
    case SP_FIELD_FILE: return sp_read_list_name(r, f, setting);
    }
    return SP_EINVAL;
}

/* "unknown key packing.widht: did you mean packing.width?", with the key or group that the scene gives as the one at
 * fault. */
static sp_status unknown(const sp_reader *r, const char *what, const char *name, const char *near, const char *right) {
    sp_fail(r->err, SP_EINVAL, "unknown %s %.60s: %s%s%s", what, name, near ? "did you mean " : "must be ",
            near ? near : right, near ? "?" : "");
    snprintf(r->err->key, sizeof r->err->key, "%.63s", name);
    return SP_EINVAL;
}

static sp_status unknown_key(const sp_reader *r, const char *group, const char *name) {
    const sp_field *near = sp_field_nearest(group, name);
    char key[128];
    snprintf(key, sizeof key, "%.60s%s%.60s", group, group[0] ? "." : "", name);
    return unknown(r, "key", key, near ? near->key : NULL, "one that `sonopack help scene` lists");
}

static sp_status unknown_group(const sp_reader *r, const char *name) {
    return unknown(r, "group", name, sp_nearest_word(name, SP_GROUPS, sp_groups),
                   "packing, material, network, signal, study or column");
}

/* A group within a group has keys of its own: packing.law.exponent. */
static sp_status read_key(sp_reader *r, const char *group, const config_setting_t *setting) {
    const char *name = config_setting_name(setting);
    char key[128];
    snprintf(key, sizeof key, "%s.%s", group, name);
    const sp_field *f = sp_field_find(key);
    sp_status status = SP_OK;
    if (!f && config_setting_is_group(setting) && sp_field_first(key)) {
        for (int k = 0; k < config_setting_length(setting) && status == SP_OK; k++)
            status = read_key(r, key, config_setting_get_elem(setting, (unsigned)k));
        return status;
    }
    if (!f)
        return unknown_key(r, group, name);
    r->given[sp_field_index(f)] = (int)r->line;
    return read_field(r, f, setting);
}

/* Reads the keys of one group. */
static sp_status read_group(sp_reader *r, const config_setting_t *group) {
    const char *name = config_setting_name(group);
    bool known = false;
    for (int k = 0; k < SP_GROUPS; k++)
        known = known || strcmp(name, sp_groups[k]) == 0;
    r->line = config_setting_source_line(group);
    sp_status status = SP_OK;
    if (known && !config_setting_is_group(group))
        status = sp_fail_key(r->err, SP_EINVAL, name, ": must be a group, %s = { ... };", name);
    else if (!known)
        status = config_setting_is_group(group) ? unknown_group(r, name) : unknown_key(r, "", name);
    const int keys = status == SP_OK ? config_setting_length(group) : 0;
    for (int k = 0; k < keys && status == SP_OK; k++) {
        const config_setting_t *setting = config_setting_get_elem(group, (unsigned)k);
        r->line = config_setting_source_line(setting);
        status = read_key(r, name, setting);
    }
    if (status == SP_EINVAL)
        sp_fail_prefix(r->err, "%s:%u", r->name, r->line);
    return status;
}

static bool is_material(const config_setting_t *group) {
    return config_setting_name(group) && strcmp(config_setting_name(group), "material") == 0;
}

static sp_status read_groups(sp_reader *r, const config_setting_t *root, bool material) {
    sp_status status = SP_OK;
    for (int k = 0; k < config_setting_length(root) && status == SP_OK; k++) {
        const config_setting_t *group = config_setting_get_elem(root, (unsigned)k);
        if (is_material(group) == material)
            status = read_group(r, group);
    }
    return status;
}

static sp_status read_material_overrides(sp_reader *r, int overrides, char *const *override);

/* The material comes first, wherever it stands: other groups may have numbers in SI units. */
static sp_status read_text(sp_reader *r, const char *text, int overrides, char *const *override) {
    config_t config;
    config_init(&config);
    sp_status status = sp_source_parse(text, r->name, &config, r->err);
    if (status != SP_OK)
        goto out;
    const config_setting_t *root = config_root_setting(&config);
    if (config_setting_length(root) == 0)
        status = sp_fail(r->err, SP_EINVAL, "%s: an empty scene: must hold at least packing = { ... };", r->name);
    if (status == SP_OK)
        status = read_groups(r, root, true);
    if (status == SP_OK)
        status = read_material_overrides(r, overrides, override);
    if (status == SP_OK)
        status = read_groups(r, root, false);
out:
    config_destroy(&config);
    return status;
}

/* Whether a value is a number with a unit, as in 100 kPa, which libconfig takes as a string only. */
static bool is_quantity(const char *value) {
    const size_t number = strspn(value, "0123456789+-.eE");
    const char *unit = value + number + strspn(value + number, " ");
    return number > 0 && *unit && *unit != 'L' && *unit != 'x' && strspn(value, "+-.eE") < number &&
           (isalpha((unsigned char)*unit) || (unit > value + number && *unit == '1')) && !strpbrk(value, "\"\\;{}[]=");
}

/* ---- --set ------------------------------------------------------------------------------------------------------- */

/* Adds a value whose words need no quotes, and whose lists of them no brackets, as it would stand in a scene. false: a
 * word follows a word. */
static bool add_words(const char *value, sp_text *out) {
    static const char ends[] = "[(,\")]{}=; \t\\";
    const bool list = strchr(value, ',') && !strchr("[(", value[strspn(value, " \t")]);
    bool after_word = false;
    sp_text_add(out, list ? "value = [" : "value = ");
    while (*value) {
        const size_t bare = strcspn(value, ends), quoted = *value == '"' ? 1 + strcspn(value + 1, "\"") : 0;
        const bool word = bare > 0 || quoted > 0, blank = *value == ' ' || *value == '\t';
        if (word && after_word)
            return false;
        const size_t length = bare > 0 ? bare : quoted > 0 && value[quoted] ? quoted + 1 : 1;
        sp_text_add(out, bare > 0 ? "\"%.*s\"" : "%.*s", (int)length, value);
        after_word = word || (blank && after_word);
        value += length;
    }
    sp_text_add(out, list ? "]" : "");
    return true;
}

static const config_setting_t *add_string(config_setting_t *root, const char *value) {
    config_setting_t *one = config_setting_add(root, "value", CONFIG_TYPE_STRING);
    return one && config_setting_set_string(one, value) ? one : NULL;
}

/* Parses a value as it would stand in a scene. Lists of numbers need no brackets. */
static sp_status parse_value(const sp_reader *r, const sp_field *f, const char *value, config_t *config) {
    const bool words = (f->type == SP_FIELD_WORD || f->type == SP_FIELD_LIST) && value[0] != '{';
    const bool numbers = f->type == SP_FIELD_REALS && value[strspn(value, "0123456789+-.eE, \t")] == '\0' &&
                         strpbrk(value, "0123456789");
    char right[200];
    sp_text text = {0};
    sp_status status = SP_OK;
    if (!words)
        sp_text_add(&text, numbers ? "value = [%s]" : "value = %s", value);
    else if (!add_words(value, &text))
        status = SP_EINVAL;
    if (text.failed)
        status = sp_fail_memory(r->err, strlen(value));
    if (status == SP_OK)
        status = sp_source_parse(text.data, "value", config, r->err);
    sp_text_free(&text);
    if (status == SP_EINVAL || (status == SP_OK && config_setting_length(config_root_setting(config)) != 1))
        return sp_fail_key(r->err, SP_EINVAL, f->key, " = %.60s: must be %s%s", value,
                           sp_field_right(f, right, sizeof right),
                           sp_field_is_number(f) ? "; of several, [a, b] or { from = a; to = b; count = 5; }" : "");
    return status;
}

static sp_status read_override_value(sp_reader *r, const sp_field *f, const char *value) {
    const bool file = (f->type == SP_FIELD_FILE || f->type == SP_FIELD_PATH) && value[0] != '"';
    const bool quantity = (sp_field_is_number(f) || f->type == SP_FIELD_REALS) && is_quantity(value);
    sp_status status = SP_OK;
    config_t config;
    config_init(&config);
    config_setting_t *root = config_root_setting(&config);
    const config_setting_t *setting = NULL;
    if (file || quantity) {
        setting = add_string(root, value);
        status = setting ? SP_OK : sp_fail_memory(r->err, strlen(value));
    } else {
        status = parse_value(r, f, value, &config);
        setting = status == SP_OK ? config_setting_get_elem(config_root_setting(&config), 0) : NULL;
    }
    if (status == SP_OK)
        status = read_field(r, f, setting);
    config_destroy(&config);
    return status;
}

static sp_status read_override(sp_reader *r, const char *override) {
    const char *equals = strchr(override, '=');
    if (!equals)
        return sp_fail(r->err, SP_EINVAL, "%.60s: must be key=value, as in packing.pressure=1e-4", override);
    char key[128];
    snprintf(key, sizeof key, "%.*s", (int)(equals - override < 127 ? equals - override : 127), override);
    key[strcspn(key, " \t")] = '\0';
    const sp_field *f = sp_field_find(key);
    if (!f) {
        char *dot = strchr(key, '.');
        if (dot)
            *dot = '\0';
        return unknown_key(r, dot ? key : "", dot ? dot + 1 : key);
    }
    r->given[sp_field_index(f)] = SP_FROM_OVERRIDE;
    r->overrides = true;
    return read_override_value(r, f, equals + 1);
}

static bool of_material(const char *override) {
    return strncmp(override, "material.", 9) == 0 || strncmp(override, "material=", 9) == 0;
}

/* Prepends to a reason where the key at fault was given. */
static sp_status locate(const sp_reader *r, sp_status status) {
    if (status != SP_EINVAL)
        return status;
    const sp_field *f = sp_field_find(r->err->key);
    const int line = f ? r->given[sp_field_index(f)] : 0;
    if (line > 0)
        return sp_fail_prefix(r->err, "%s:%d", r->name, line);
    if (line == SP_FROM_OVERRIDE)
        return sp_fail_prefix(r->err, "--set");
    return r->name ? sp_fail_prefix(r->err, "%s", r->name) : status;
}

/* "material=E=...,nu=...": what --material gives. Unlike the group it leaves packing.poisson alone, and so all samples
 * keep their names. */
static sp_status read_whole_material(sp_reader *r, const char *override) {
    return sp_material_read(override + strlen("material="), &r->scene.material, r->err);
}

/* Reads the overrides of the material, and completes what the group has given. */
static sp_status read_material_overrides(sp_reader *r, int overrides, char *const *override) {
    sp_status status = SP_OK;
    for (int whole = 0; whole < 2 && status == SP_OK; whole++) {
        for (int k = 0; k < overrides && status == SP_OK; k++) {
            if (strncmp(override[k], whole ? "material=" : "material.", 9) != 0)
                continue;
            status = whole ? read_whole_material(r, override[k]) : read_override(r, override[k]);
            if (status == SP_EINVAL)
                sp_fail_prefix(r->err, "--set");
        }
        if (status == SP_OK && !whole)
            status = locate(r, sp_reader_check_material(r));
    }
    r->overrides = false;
    return status;
}

/* A check of the finished scene. */
typedef sp_status (*scene_check)(sp_reader *r);

static sp_status read_all(const char *text, const char *name, int overrides, char *const *override, scene_check check,
                          sp_scene *out, sp_error *err) {
    sp_error own = {0}; /* decisions here need the key at fault, even if the caller passes no err */
    sp_reader r = {.scene = sp_scene_default(), .name = text && !name ? "scene" : name, .err = err ? err : &own};
    sp_status status =
        text ? read_text(&r, text, overrides, override) : read_material_overrides(&r, overrides, override);
    for (int k = 0; k < overrides && status == SP_OK; k++) {
        if (of_material(override[k]))
            continue;
        status = read_override(&r, override[k]);
        if (status == SP_EINVAL)
            sp_fail_prefix(r.err, "--set");
    }
    if (status == SP_OK)
        status = locate(&r, check(&r));
    if (status == SP_OK)
        *out = r.scene;
    else
        sp_scene_free(&r.scene);
    for (int k = 0; k < r.directs; k++)
        sp_sweep_free(&r.direct[k]);
    return status;
}

sp_status sp_scene_parse(const char *text, const char *name, int overrides, char *const *override, sp_scene *out,
                         sp_error *err) {
    return read_all(text, name, overrides, override, sp_reader_check, out, err);
}

static sp_status read_file(const char *path, int overrides, char *const *override, scene_check check, sp_scene *out,
                           sp_error *err) {
    if (!path)
        return read_all(NULL, NULL, overrides, override, check, out, err);
    char *text = NULL;
    sp_status status = sp_source_load(path, "scene", &text, err);
    if (status == SP_OK)
        status = read_all(text, path, overrides, override, check, out, err);
    sp_free(text);
    return status;
}

sp_status sp_scene_read(const char *path, int overrides, char *const *override, sp_scene *out, sp_error *err) {
    return read_file(path, overrides, override, sp_reader_check, out, err);
}

sp_status sp_scene_read_tapped(const char *path, int overrides, char *const *override, sp_scene *out, sp_error *err) {
    return read_file(path, overrides, override, sp_reader_check_tapped, out, err);
}
