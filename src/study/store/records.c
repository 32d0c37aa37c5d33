/* Records of failed samples: text files of keys and values. Lines of the cache: a sample and its file, in cells
 * separated by tabs, and a checksum. */
#include "store/records.h"

#include "base/base.h"
#include "base/file.h"
#include "store/sample_h5.h"

#include <fcntl.h>
#include <search.h>
#include <sonopack/study/store.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SUM_DIGITS = 16 };

static const sp_h5_field of_signal[] = {
    {{"/results/signal/points", "", ""}, SP_H5_I32, offsetof(sp_sample, signal.points)},
    {{"/results/signal/method", "", ""}, SP_H5_I32, offsetof(sp_sample, signal.method)},
    {{"/results/signal/until", "", ""}, SP_H5_F64, offsetof(sp_sample, signal.until)},
    {{"/results/signal/tolerance", "", ""}, SP_H5_F64, offsetof(sp_sample, signal.tolerance)},
    {{"/results/planes", "", ""}, SP_H5_I32, offsetof(sp_sample, planes)},
};
enum { OF_SIGNAL = sizeof of_signal / sizeof *of_signal, COLUMNS_MAX = SP_RESULTS_MAX + OF_SIGNAL };

/* All single numbers of a sample. Those of parts that it lacks are written as they are in memory. */
static int columns(sp_result out[COLUMNS_MAX]) {
    const int results = sp_results(out);
    for (int k = 0; k < OF_SIGNAL; k++)
        out[results + k] = (sp_result){.field = &of_signal[k], .offset = of_signal[k].offset};
    return results + OF_SIGNAL;
}

/* The lines with which the file begins. They name the columns, and identify the format. */
static void put_head(sp_text *out) {
    sp_result column[COLUMNS_MAX];
    const int count = columns(column);
    sp_text_add(out, "# cache of the samples in this folder; may be deleted, and is made anew from their files\n"
                     "name\tfile\tbytes\tmodified\tparts");
    for (int k = 0; k < count; k++)
        sp_text_add(out, "\t%s", column[k].field->name.path + strlen("/results/"));
    sp_text_add(out, "\tat_planes\treason\tchecksum\n");
}

/* ---- writing --------------------------------------------------------------------------------------------------- */

static void put_number(sp_text *out, const sp_sample *s, const sp_result *of) {
    const char *place = (const char *)s + of->offset;
    const sp_h5_type type = of->field->type;
    double real;
    int32_t narrow;
    uint64_t wide;
    if (type == SP_H5_F64) {
        memcpy(&real, place, sizeof real);
        sp_text_number(out, real);
    } else if (type == SP_H5_I32) {
        memcpy(&narrow, place, sizeof narrow);
        sp_text_add(out, "%d", narrow);
    } else {
        memcpy(&wide, place, sizeof wide);
        sp_text_add(out, "%llu", (unsigned long long)wide);
    }
}

static void put_planes(sp_text *out, const sp_sample *s) {
    for (int32_t k = 0; k < s->planes; k++)
        for (int i = 0; i < SP_PLANE_FIELDS; i++) {
            sp_text_add(out, " ");
            sp_text_number(out, sp_plane_number(&sp_plane_fields[i], s, k));
        }
}

static int64_t time_of(const struct stat *file) {
    return (int64_t)file->st_mtim.tv_sec * 1000000000 + file->st_mtim.tv_nsec;
}

static void put_file(sp_text *out, const char *name, bool failed, const struct stat *file) {
    sp_text_add(out, "%s\t%s\t%lld\t%lld\t", name, failed ? "failed" : "h5", (long long)file->st_size,
                (long long)time_of(file));
}

void sp_manifest_put(sp_text *out, const struct stat *file, const sp_sample *s) {
    sp_result column[COLUMNS_MAX];
    const int count = columns(column);
    const size_t begin = out->size;
    char reason[sizeof s->reason];
    memcpy(reason, s->reason, sizeof reason);
    sp_text_tame(reason, "");
    sp_locale locale = sp_locale_enter();
    put_file(out, s->name, s->failed, file);
    sp_text_add(out, "%u\t", s->have);
    for (int k = 0; k < count; k++) {
        put_number(out, s, &column[k]);
        sp_text_add(out, "\t");
    }
    put_planes(out, s);
    sp_text_add(out, "\t%s\t", reason);
    sp_locale_leave(&locale);
    if (!out->failed)
        sp_text_add(out, "%016llx\n",
                    (unsigned long long)sp_hash64(SP_HASH64_BEGIN, out->data + begin, out->size - begin));
}

/* ---- reading --------------------------------------------------------------------------------------------------- */

static bool is_sound(const char *line) {
    const size_t length = strlen(line);
    char sum[SUM_DIGITS + 1];
    if (length <= SUM_DIGITS)
        return false;
    snprintf(sum, sizeof sum, "%016llx", (unsigned long long)sp_hash64(SP_HASH64_BEGIN, line, length - SUM_DIGITS));
    return strcmp(sum, line + length - SUM_DIGITS) == 0;
}

/* Cuts off the next cell; "" at the end, which no number has. */
static char *next_cell(char **rest) {
    char *cell = *rest, *tab = strchr(cell, '\t');
    *rest = tab ? tab + 1 : cell + strlen(cell);
    if (tab)
        *tab = '\0';
    return cell;
}

static bool get_number(const char *cell, sp_sample *s, const sp_result *of) {
    char *place = (char *)s + of->offset;
    const sp_h5_type type = of->field->type;
    double real;
    int64_t integer;
    uint64_t wide;
    if (type == SP_H5_F64)
        return sp_word_number(cell, &real) && memcpy(place, &real, sizeof real);
    if (type == SP_H5_I32)
        return sp_word_integer(cell, &integer) && integer >= INT32_MIN && integer <= INT32_MAX &&
               memcpy(place, &(int32_t){(int32_t)integer}, sizeof(int32_t));
    return sp_word_unsigned(cell, &wide) && memcpy(place, &wide, sizeof wide);
}

static bool get_planes(char *cell, sp_sample *s) {
    char *word[SP_PLANE_FIELDS * SP_PLANES_MAX];
    const int numbers = SP_PLANE_FIELDS * s->planes;
    if (s->planes < 0 || s->planes > SP_PLANES_MAX || sp_line_words(cell, word, numbers) != numbers)
        return false;
    for (int k = 0; k < numbers; k++) {
        double number;
        if (!sp_word_number(word[k], &number))
            return false;
        sp_plane_set(&sp_plane_fields[k % SP_PLANE_FIELDS], s, k / SP_PLANE_FIELDS, number);
    }
    return true;
}

static bool get_sample(char *rest, sp_sample *s) {
    sp_result column[COLUMNS_MAX];
    const int count = columns(column);
    int64_t have;
    bool good = sp_word_integer(next_cell(&rest), &have) && have >= 0 && have <= UINT32_MAX;
    s->have = good ? (unsigned)have : 0;
    for (int k = 0; good && k < count; k++)
        good = get_number(next_cell(&rest), s, &column[k]);
    good = good && get_planes(next_cell(&rest), s);
    if (good)
        snprintf(s->reason, sizeof s->reason, "%s", next_cell(&rest));
    return good && !sp_sample_fault(s) && sp_signal_method_name(s->signal.method);
}

bool sp_manifest_get(char *line, const char *name, bool failed, const struct stat *file, sp_sample *out) {
    sp_text begin = {0};
    put_file(&begin, name, failed, file);
    const bool same = !begin.failed && strncmp(line, begin.data, begin.size) == 0 && is_sound(line);
    sp_sample s = sp_sample_blank();
    s.failed = failed;
    snprintf(s.name, sizeof s.name, "%s", name);
    sp_locale locale = sp_locale_enter();
    const bool good = same && get_sample(line + begin.size, &s);
    sp_locale_leave(&locale);
    sp_text_free(&begin);
    if (good)
        *out = s;
    return good;
}

/* ---- records of failures ----------------------------------------------------------------------------------------- */

/* Keys that every record has beside the reason; and those that it has where they are not 0. */
static const char *const keys[] = {"dim",  "grains", "width",    "pressure", "friction",
                                   "seed", "kind",   "fraction", "stage",    "strain"};
enum { KEYS = sizeof keys / sizeof *keys, NEEDED = 6 };

/* The number of this key; false for another word. */
static bool find_key(const char *key, sp_result *out, int *which) {
    sp_result result[SP_RESULTS_MAX];
    const int results = sp_results(result);
    for (*which = 0; *which < KEYS; ++*which)
        if (strcmp(key, keys[*which]) == 0)
            break;
    for (int k = 0; *which < KEYS && k < results; k++)
        if (strcmp(result[k].field->name.path + strlen("/results/sample/"), key) == 0) {
            *out = result[k];
            return true;
        }
    return false;
}

sp_status sp_failure_save(const char *path, const sp_sample *s, sp_error *err) {
    sp_text t = {0};
    char reason[sizeof s->reason];
    sp_result number;
    int which;
    memcpy(reason, s->reason, sizeof reason);
    sp_text_tame(reason, "");
    sp_locale locale = sp_locale_enter();
    sp_text_add(&t, "# This sample failed. `sonopack study --retry' tries it again.\nreason = %s\n", reason);
    for (int k = 0; k < KEYS; k++)
        if (find_key(keys[k], &number, &which) && (which < NEEDED || !sp_is_zero(number.field, s))) {
            sp_text_add(&t, "%s = ", keys[k]);
            put_number(&t, s, &number);
            sp_text_add(&t, "\n");
        }
    sp_locale_leave(&locale);
    sp_status status = t.failed ? sp_fail_memory(err, t.capacity) : sp_text_save(path, t.data, t.size, err);
    sp_text_free(&t);
    return status;
}

/* Stores the value of a "key = value" line in the sample. Unknown keys are ignored. */
static bool take_line(const char *key, const char *value, bool given[KEYS], sp_sample *s) {
    sp_result number;
    int which;
    if (strcmp(key, "reason") == 0)
        snprintf(s->reason, sizeof s->reason, "%s", value);
    if (!find_key(key, &number, &which))
        return true;
    given[which] = true;
    return get_number(value, s, &number);
}

static sp_status parse(sp_lines *lines, sp_sample *s, sp_error *err) {
    bool given[KEYS] = {false};
    for (;;) {
        char *line;
        sp_status status = sp_lines_next_data(lines, &line, err);
        for (int k = 0; k < NEEDED && status == SP_OK && !line; k++)
            if (!given[k] || !s->reason[0])
                status = sp_fail(err, SP_EFORMAT, "%s: no line '%s = ...': not a whole record of a failed sample",
                                 lines->file, given[k] ? "reason" : keys[k]);
        if (status != SP_OK || !line)
            return status;
        char *equal = strstr(line, " = ");
        if (equal)
            *equal = '\0';
        if (!equal || !take_line(line, equal + 3, given, s))
            return sp_fail(err, SP_EFORMAT, "%s:%lld: '%.60s' is no 'key = value' of a failed sample", lines->file,
                           (long long)lines->number, line);
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

/* ---- the cache ----------------------------------------------------------------------------------------------------
 */

enum { NAME = 32, LONGEST_LINE = 16384 };

/* Place of the last line of a sample. */
typedef struct manifest_line {
    char name[NAME + 1];
    int32_t length; /* without the end of line */
    int64_t at;     /* from the beginning of the file */
} manifest_line;

struct sp_manifest {
    char path[SP_PATH_MAX];
    sp_text head;
    int fd; /* negative: there is no readable file */
    bool adding;
    int64_t read_to; /* lines up to here are in the tree */
    void *tree;      /* of entries, by their names (tsearch) */
};

static int compare_names(const void *a, const void *b) {
    return strcmp(((const manifest_line *)a)->name, ((const manifest_line *)b)->name);
}

/* Whether the line is in the tree, or not one of a sample. */
static bool index_line(sp_manifest *m, const char *line, int64_t length, int64_t at) {
    if (length <= NAME || length >= LONGEST_LINE || line[NAME] != '\t')
        return true;
    manifest_line *fresh = sp_alloc(1, sizeof *fresh);
    if (!fresh)
        return false;
    *fresh = (manifest_line){.length = (int32_t)length, .at = at};
    memcpy(fresh->name, line, NAME);
    manifest_line **found = tsearch(fresh, &m->tree, compare_names);
    if (found && *found != fresh) {
        (*found)->length = fresh->length;
        (*found)->at = at;
    }
    if (!found || *found != fresh)
        sp_free(fresh);
    return found != NULL;
}

void sp_manifest_refresh(sp_manifest *m) {
    struct stat info;
    if (m->fd < 0 || fstat(m->fd, &info) != 0 || info.st_size <= m->read_to)
        return;
    char *text = sp_alloc((size_t)(info.st_size - m->read_to) + 1, 1);
    const int64_t got = text ? sp_file_read_at(m->fd, text, (size_t)(info.st_size - m->read_to), m->read_to) : 0;
    const char *line = text, *stop;
    while (line && (stop = memchr(line, '\n', (size_t)(got > 0 ? text + got - line : 0)))) {
        if (!index_line(m, line, stop - line, m->read_to + (line - text)))
            break;
        line = stop + 1;
    }
    m->read_to += line ? line - text : 0;
    sp_free(text);
}

/* Opens the file. False if there is none of this format. */
static bool open_file(sp_manifest *m) {
    struct stat info;
    char *first = sp_alloc(m->head.size, 1);
    m->fd = open(m->path, (m->adding ? O_RDWR | O_APPEND : O_RDONLY) | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    const bool good = first && m->fd >= 0 && fstat(m->fd, &info) == 0 && S_ISREG(info.st_mode) &&
                      sp_file_read_at(m->fd, first, m->head.size, 0) == (int64_t)m->head.size &&
                      memcmp(first, m->head.data, m->head.size) == 0;
    sp_free(first);
    if (!good && m->fd >= 0) {
        close(m->fd);
        m->fd = -1;
    }
    return good;
}

sp_status sp_manifest_open(const char *dir, bool adding, sp_manifest **out, sp_error *err) {
    struct stat info;
    sp_manifest *m = sp_alloc(1, sizeof *m);
    if (!m)
        return sp_fail_memory(err, sizeof *m);
    m->fd = -1;
    m->adding = adding;
    snprintf(m->path, sizeof m->path, "%s/manifest.tsv", dir);
    put_head(&m->head);
    if (m->head.failed) {
        sp_manifest_close(m);
        return sp_fail_memory(err, sizeof *m);
    }
    /* anything but a regular file is left alone */
    if (!open_file(m) && adding && !(lstat(m->path, &info) == 0 && !S_ISREG(info.st_mode)) &&
        sp_file_write(m->path, m->head.data, m->head.size, NULL) == SP_OK)
        open_file(m);
    sp_manifest_refresh(m);
    *out = m;
    return SP_OK;
}

void sp_manifest_close(sp_manifest *m) {
    if (!m)
        return;
    if (m->fd >= 0)
        close(m->fd);
    tdestroy(m->tree, sp_free);
    sp_text_free(&m->head);
    sp_free(m);
}

bool sp_manifest_find(const sp_manifest *m, const char *name, bool failed, const struct stat *file, sp_sample *out) {
    char line[LONGEST_LINE];
    manifest_line key;
    snprintf(key.name, sizeof key.name, "%s", name);
    manifest_line *const *found = tfind(&key, &m->tree, compare_names);
    if (!found || sp_file_read_at(m->fd, line, (size_t)(*found)->length, (*found)->at) != (*found)->length)
        return false;
    line[(*found)->length] = '\0';
    return sp_manifest_get(line, name, failed, file, out);
}

void sp_manifest_add(sp_manifest *m, const struct stat *file, const sp_sample *sample) {
    sp_text text = {0};
    char last = '\n';
    if (!m->adding || m->fd < 0)
        return;
    if (sp_file_read_at(m->fd, &last, 1, lseek(m->fd, 0, SEEK_END) - 1) == 1 && last != '\n')
        sp_text_add(&text, "\n"); /* a line was cut off there */
    sp_manifest_put(&text, file, sample);
    if (!text.failed)
        (void)!write(m->fd, text.data, text.size);
    sp_text_free(&text);
    sp_manifest_refresh(m);
}
