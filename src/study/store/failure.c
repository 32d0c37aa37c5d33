/* Records of failed samples: text files of keys and values. */
#include "store/failure.h"

#include "base/base.h"
#include "base/file.h"
#include "base/text.h"
#include "store/sample_h5.h"

#include <math.h>
#include <sonopack/study/store.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

sp_status sp_failure_save(const char *path, const sp_sample *s, sp_error *err) {
    sp_text t = {0};
    char reason[sizeof s->reason];
    snprintf(reason, sizeof reason, "%s", s->reason);
    for (char *c = reason; *c; c++)
        if ((unsigned char)*c < ' ')
            *c = ' ';
    sp_locale locale = sp_locale_enter();
    sp_text_add(&t, "# This sample failed. `sonopack study --retry' tries it again.\nreason = %s\n", reason);
    sp_text_add(&t, "dim = %d\ngrains = %d\nwidth = %.17g\npressure = %.17g\nfriction = %.17g\nseed = %llu\n", s->dim,
                s->grains, s->width, s->pressure, s->friction, (unsigned long long)s->seed);
    if (s->kind != SP_PACK_PISTON)
        sp_text_add(&t, "kind = %d\n", s->kind);
    sp_locale_leave(&locale);
    sp_status status = t.failed ? sp_fail_memory(err, t.capacity) : sp_text_save(path, t.data, t.size, err);
    sp_text_free(&t);
    return status;
}

/* Keys that every record has. */
static const char *const keys[] = {"reason", "dim", "grains", "width", "pressure", "friction", "seed"};
enum { KEYS = sizeof keys / sizeof *keys };

/* Stores the value of a "key = value" line in the sample. Unknown keys are ignored. */
static bool take_line(const char *key, const char *value, sp_sample *s) {
    double *number = strcmp(key, "width") == 0      ? &s->width
                     : strcmp(key, "pressure") == 0 ? &s->pressure
                     : strcmp(key, "friction") == 0 ? &s->friction
                                                    : NULL;
    int32_t *integer = strcmp(key, "dim") == 0      ? &s->dim
                       : strcmp(key, "grains") == 0 ? &s->grains
                       : strcmp(key, "kind") == 0   ? &s->kind
                                                    : NULL;
    if (number)
        return sp_word_number(value, number) && isfinite(*number);
    if (integer) {
        int64_t whole;
        bool good = sp_word_integer(value, &whole) && whole >= 0 && whole <= INT32_MAX;
        *integer = good ? (int32_t)whole : 0;
        return good;
    }
    if (strcmp(key, "seed") == 0)
        return sp_word_unsigned(value, &s->seed);
    if (strcmp(key, "reason") == 0)
        snprintf(s->reason, sizeof s->reason, "%s", value);
    return true;
}

static sp_status parse(sp_lines *lines, sp_sample *s, sp_error *err) {
    bool given[KEYS] = {false};
    for (;;) {
        char *line;
        sp_status status = sp_lines_next_data(lines, &line, err);
        for (int k = 0; k < KEYS && status == SP_OK && !line; k++)
            if (!given[k])
                status = sp_fail(err, SP_EFORMAT, "%s: no line '%s = ...': not a whole record of a failed sample",
                                 lines->file, keys[k]);
        if (status != SP_OK || !line)
            return status;
        char *equal = strstr(line, " = ");
        if (equal)
            *equal = '\0';
        if (!equal || !take_line(line, equal + 3, s))
            return sp_fail(err, SP_EFORMAT, "%s:%lld: '%.60s' is no 'key = value' of a failed sample", lines->file,
                           (long long)lines->number, line);
        for (int k = 0; k < KEYS; k++)
            given[k] = given[k] || strcmp(line, keys[k]) == 0;
    }
}

sp_status sp_failure_read(const char *path, const char *name, sp_sample *out, sp_error *err) {
    char *text = NULL;
    size_t size = 0;
    sp_sample s = {.failed = true};
    struct stat info;
    snprintf(s.name, sizeof s.name, "%s", name);
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode)) /* reading a pipe or a device might never end */
        return sp_fail(err, SP_EFORMAT, "%s: not a regular file, which a record of a failed sample must be", path);
    sp_status status = sp_file_read_text(path, &text, &size, err);
    if (status == SP_OK && (size == 0 || text[size - 1] != '\n')) {
        sp_free(text);
        status = sp_fail(err, SP_EFORMAT, "%s: its last line has no end: not a whole record of a failed sample", path);
    }
    if (status != SP_OK)
        return status;
    sp_lines lines = sp_lines_of(path, text, size);
    sp_locale locale = sp_locale_enter();
    status = parse(&lines, &s, err);
    sp_locale_leave(&locale);
    sp_free(text);
    const char *bad = status == SP_OK ? sp_sample_fault(&s) : NULL;
    if (bad)
        return sp_fail(err, SP_EFORMAT, "%s: %s is no value of a sample", path, bad);
    if (status == SP_OK)
        *out = s;
    return status;
}
