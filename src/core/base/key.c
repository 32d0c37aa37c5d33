/* Values and ranges of the keys in a spec. */
#include "base/key.h"

#include "base/base.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

uint64_t sp_key_integer(const sp_key *key, const void *spec) {
    const char *place = (const char *)spec + key->offset;
    int32_t narrow;
    uint64_t wide;
    switch (key->type) {
    case SP_KEY_INT64: memcpy(&wide, place, sizeof wide); return wide;
    case SP_KEY_BOOL: return *(const bool *)place;
    default: memcpy(&narrow, place, sizeof narrow); return (uint64_t)narrow;
    }
}

double sp_key_value(const sp_key *key, const void *spec) {
    double real;
    if (key->type == SP_KEY_REAL) {
        memcpy(&real, (const char *)spec + key->offset, sizeof real);
        return real;
    }
    const uint64_t integer = sp_key_integer(key, spec);
    return key->high > 0x1p63 ? (double)integer : (double)(int64_t)integer;
}

bool sp_key_allows(const sp_key *key, double value) {
    return (value >= key->low && value <= key->high) || (key->zero && value == 0);
}

static const char *limit_text(const sp_key *key, double limit, char text[SP_NUMBER_TEXT]) {
    if (key->type == SP_KEY_REAL || key->type == SP_KEY_REALS)
        return sp_number_plain(limit, text);
    snprintf(text, SP_NUMBER_TEXT, "%lld", limit >= 0x1p63 ? (long long)INT64_MAX : (long long)limit);
    return text;
}

const char *sp_key_range(const sp_key *key, char *buf, size_t size) {
    char low[SP_NUMBER_TEXT], high[SP_NUMBER_TEXT];
    const bool integer = key->type == SP_KEY_INT || key->type == SP_KEY_INT64;
    snprintf(buf, size, "%s%s .. %s%s%s%s", integer ? "an integer " : "", limit_text(key, key->low, low),
             limit_text(key, key->high, high), key->unit[0] ? " " : "", key->unit, key->zero ? ", or 0" : "");
    return buf;
}

static sp_status check_list(const sp_key *key, const void *spec, sp_error *err) {
    const double *values;
    int32_t count;
    char text[SP_NUMBER_TEXT], range[128];
    memcpy(&values, (const char *)spec + key->offset, sizeof values);
    memcpy(&count, (const char *)spec + key->count, sizeof count);
    for (int32_t k = 0; values && k < count; k++)
        if (!sp_key_allows(key, values[k]))
            return sp_fail_key(err, SP_EINVAL, key->name, ": number %d = %s: must be %s", k + 1,
                               sp_number_text(values[k], text), sp_key_range(key, range, sizeof range));
    return SP_OK;
}

sp_status sp_keys_check(const sp_key *keys, const void *spec, sp_error *err) {
    char text[SP_NUMBER_TEXT], range[128];
    sp_status status = SP_OK;
    for (const sp_key *key = keys; key->name && status == SP_OK; key++) {
        if (key->type == SP_KEY_REALS)
            status = check_list(key, spec, err);
        else if (!sp_key_allows(key, sp_key_value(key, spec)))
            status = sp_fail_key(err, SP_EINVAL, key->name, " = %s: must be %s",
                                 sp_number_text(sp_key_value(key, spec), text), sp_key_range(key, range, sizeof range));
    }
    return status;
}
