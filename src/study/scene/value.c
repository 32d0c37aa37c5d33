/* Reads single values from the settings of libconfig. */
#include "base/base.h"
#include "scene/reader.h"

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
