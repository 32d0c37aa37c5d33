/* Writes metadata as comment lines "key = value" and finds it again. */
#include "table/metadata.h"

#include "base/base.h"
#include "base/text.h"
#include "table/array.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *skip_blanks(const char *text) { return text + strspn(text, " \t"); }

/* A new string without the blanks at the end. */
static char *copy_trimmed(const char *text, size_t length) {
    while (length > 0 && (text[length - 1] == ' ' || text[length - 1] == '\t'))
        length--;
    char *copy = sp_alloc(length + 1, 1);
    if (copy)
        memcpy(copy, text, length);
    return copy;
}

/* The number that a text begins with; NAN without one. *whole: nothing follows it. */
static double leading_number(const char *text, bool *whole) {
    char *end;
    sp_locale locale = sp_locale_enter();
    const double value = strtod(text, &end);
    sp_locale_leave(&locale);
    *whole = end > text && *end == '\0';
    return end > text ? value : NAN;
}

/* ---- reading ---------------------------------------------------------------------------------------------------- */

/* Where the key ends: at the first " = ", since a key itself may have an equals sign, as in "gamma(p=1e-6)"; in a line
 * without blanks around it, at the first equals sign. NULL: no metadata. */
static const char *equals_sign(const char *line) {
    const char *blanks = strstr(line, " = ");
    return blanks ? blanks + 1 : strchr(line, '=');
}

static sp_status add_value(sp_table *t, const char *key, size_t key_length, const char *text, size_t length,
                           sp_error *err) {
    sp_table_value *larger = sp_array_reserve(t->value, (size_t)t->values, sizeof *larger);
    if (!larger)
        return sp_fail_memory(err, (size_t)t->values * sizeof *larger);
    t->value = larger;
    sp_table_value *v = &t->value[t->values];
    *v = (sp_table_value){.key = copy_trimmed(key, key_length), .text = copy_trimmed(text, length)};
    if (!v->key || !v->text) {
        sp_free(v->key);
        sp_free(v->text);
        return sp_fail_memory(err, key_length + length);
    }
    int64_t integer;
    bool whole;
    v->comment = t->comments - 1;
    v->number = leading_number(v->text, &whole);
    v->kind = sp_word_integer(v->text, &integer) ? SP_COLUMN_INTEGER : whole ? SP_COLUMN_NUMBER : SP_COLUMN_TEXT;
    t->values++;
    return SP_OK;
}

/* Tables of means say in a sentence what their intervals are: "..., its interval at level 0.95, ...". */
static sp_status index_sentence(sp_table *t, const char *line, sp_error *err) {
    static const char words[] = "interval at level ", key[] = "interval_level";
    const char *level = strstr(line, words);
    if (!level)
        return SP_OK;
    level += strlen(words);
    return add_value(t, key, strlen(key), level, strcspn(level, ",; \n"), err);
}

/* Records the metadata in the last comment line, if there is any. */
static sp_status index_comment(sp_table *t, sp_error *err) {
    const char *line = t->comment[t->comments - 1], *key = skip_blanks(line), *sign;
    /* "pressure = 1e-4, grains = 1024, ..." and "dimension = 2, friction = 0.5, ..." */
    const bool list = strncmp(key, "pressure = ", 11) == 0 || strncmp(key, "dimension = ", 12) == 0;
    sp_status status = index_sentence(t, line, err);
    while (status == SP_OK && key && (sign = equals_sign(key)) != NULL && sign > key) {
        const char *text = skip_blanks(sign + 1), *comma = list ? strstr(text, ", ") : NULL;
        const size_t length = comma ? (size_t)(comma - text) : strcspn(text, "\n");
        status = add_value(t, key, (size_t)(sign - key), text, length, err);
        key = comma ? skip_blanks(comma + 1) : NULL;
    }
    return status;
}

sp_status sp_table_add_comment(sp_table *t, sp_error *err, const char *format, ...) {
    char line[2048];
    va_list args;
    sp_locale locale = sp_locale_enter();
    va_start(args, format);
    vsnprintf(line, sizeof line, format, args);
    va_end(args);
    sp_locale_leave(&locale);
    sp_status status = sp_table_add_line(t, line, err);
    return status == SP_OK ? index_comment(t, err) : status;
}

static const sp_table_value *find(const sp_table *t, const char *key) {
    for (int k = 0; k < t->values; k++)
        if (strcmp(t->value[k].key, key) == 0)
            return &t->value[k];
    return NULL;
}

bool sp_table_get_number(const sp_table *t, const char *key, double *value) {
    const sp_table_value *v = find(t, key);
    if (!v || !isfinite(v->number))
        return false;
    *value = v->number;
    return true;
}

const char *sp_table_get_text(const sp_table *t, const char *key) {
    const sp_table_value *v = find(t, key);
    return v ? v->text : NULL;
}

/* ---- writing ---------------------------------------------------------------------------------------------------- */

sp_status sp_table_set_text(sp_table *t, const char *key, const char *value, sp_error *err) {
    if (find(t, key))
        return sp_fail(err, SP_EINVAL, "%s: the table already has this metadata", key);
    char line[2048];
    snprintf(line, sizeof line, "%s = %s", key, value);
    sp_status status = sp_table_add_line(t, line, err);
    return status == SP_OK ? add_value(t, key, strlen(key), value, strlen(value), err) : status;
}

sp_status sp_table_set_integer(sp_table *t, const char *key, int64_t value, sp_error *err) {
    char text[24];
    snprintf(text, sizeof text, "%lld", (long long)value);
    return sp_table_set_text(t, key, text, err);
}

sp_status sp_table_set_number(sp_table *t, const char *key, double value, int digits, sp_error *err) {
    char text[SP_NUMBER_TEXT];
    if (digits < 0 || digits > 17)
        return sp_fail(err, SP_EINVAL, "%s: %d digits: must be 0 to 17", key, digits);
    sp_number_text(value, text);
    if (digits > 0 && isfinite(value)) {
        sp_locale locale = sp_locale_enter();
        snprintf(text, sizeof text, "%.*g", digits, value);
        sp_locale_leave(&locale);
    }
    return sp_table_set_text(t, key, text, err);
}
