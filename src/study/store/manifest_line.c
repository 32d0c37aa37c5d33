/* Lines of the manifest: a sample and its file, in cells separated by tabs, and a checksum. */
#include "base/base.h"
#include "store/manifest.h"
#include "store/sample_h5.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SUM_DIGITS = 16, PLANE_NUMBERS = 6 };

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

void sp_manifest_head(sp_text *out) {
    sp_result column[COLUMNS_MAX];
    const int count = columns(column);
    sp_text_add(out, "# cache of the samples in this folder; may be deleted, and is made anew from their files\n"
                     "name\tfile\tbytes\tmodified\tparts");
    for (int k = 0; k < count; k++)
        sp_text_add(out, "\t%s", column[k].field->name.path + strlen("/results/"));
    sp_text_add(out, "\tat_planes\treason\tchecksum\n");
}

/* ---- writing --------------------------------------------------------------------------------------------------- */

static void put_number(sp_text *out, const void *place, sp_h5_type type) {
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
    for (int32_t k = 0; k < s->planes; k++) {
        const sp_front *f = &s->plane_front[k];
        const double number[PLANE_NUMBERS] = {s->plane[k], f->t10, f->t_peak, f->t_zero, f->amplitude, f->width};
        for (int i = 0; i < PLANE_NUMBERS; i++) {
            sp_text_add(out, " ");
            sp_text_number(out, number[i]);
        }
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
    snprintf(reason, sizeof reason, "%s", s->reason);
    for (char *c = reason; *c; c++)
        if ((unsigned char)*c < ' ')
            *c = ' ';
    sp_locale locale = sp_locale_enter();
    put_file(out, s->name, s->failed, file);
    sp_text_add(out, "%u\t", s->have);
    for (int k = 0; k < count; k++) {
        put_number(out, (const char *)s + column[k].offset, column[k].field->type);
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

static bool get_number(const char *cell, void *place, sp_h5_type type) {
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
    char *word[PLANE_NUMBERS * SP_PLANES_MAX];
    double n[PLANE_NUMBERS] = {0};
    if (s->planes < 0 || s->planes > SP_PLANES_MAX ||
        sp_line_words(cell, word, PLANE_NUMBERS * s->planes) != PLANE_NUMBERS * s->planes)
        return false;
    for (int32_t k = 0; k < s->planes; k++) {
        for (int i = 0; i < PLANE_NUMBERS; i++)
            if (!sp_word_number(word[PLANE_NUMBERS * k + i], &n[i]))
                return false;
        s->plane[k] = n[0];
        s->plane_front[k] = (sp_front){.t10 = n[1], .t_peak = n[2], .t_zero = n[3], .amplitude = n[4], .width = n[5]};
    }
    return true;
}

static bool get_sample(char *rest, sp_sample *s) {
    sp_result column[COLUMNS_MAX];
    const int count = columns(column);
    bool good = get_number(next_cell(&rest), &s->have, SP_H5_I32);
    for (int k = 0; good && k < count; k++)
        good = get_number(next_cell(&rest), (char *)s + column[k].offset, column[k].field->type);
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
